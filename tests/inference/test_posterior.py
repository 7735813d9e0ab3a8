from __future__ import annotations

import math

import numpy as np
import pytest
import torch

from sloop_ppl.errors import BeliefCollapse, DescriptionError, InputError, UnknownName
from sloop_ppl.inference import Posterior, infer_description
from sloop_ppl.inference._enumeration import description_tables
from sloop_ppl.maps import load_map
from sloop_ppl.models import Program, ground_relations, program_data
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(21), house=(12.0, -7.0), street_y=30.0)
BEHIND = said(relation("behind", "House"))
NEAR = said(relation("near", "MainSt"))


def posterior(description=BEHIND, model=MIXTURE, **options):
    return infer_description(description, CITY, model, **options)[0]


def test_updates_commute():
    one = posterior(BEHIND).update(NEAR)
    other = posterior(NEAR).update(BEHIND)
    np.testing.assert_allclose(one.belief(TARGET), other.belief(TARGET), atol=1e-14)
    assert one.log_evidence == pytest.approx(other.log_evidence)
    assert set(one.texts) == set(other.texts)


def test_an_update_multiplies_the_likelihoods():
    product = posterior(BEHIND).belief(TARGET) * posterior(NEAR).belief(TARGET)
    got = posterior(BEHIND).update(NEAR).belief(TARGET)
    np.testing.assert_allclose(got, product / product.sum(), atol=1e-14)


def test_two_updates_are_not_one_longer_description():
    """A new component is drawn for each description, one for the whole of a longer one."""
    longer = posterior(said(relation("behind", "House"), relation("near", "MainSt")))
    twice = posterior(BEHIND).update(NEAR)
    assert 0.5 * np.abs(longer.belief(TARGET) - twice.belief(TARGET)).sum() > 0.01


def test_an_update_may_bring_a_new_target():
    later = said(relation("on", "MainSt", figure="RedBike"), targets=("RedBike",))
    both = posterior().update(later)
    assert both.targets == (TARGET, "RedBike")
    np.testing.assert_allclose(both.belief(TARGET), posterior().belief(TARGET))


def test_sensing_moves_cells_components_and_frames():
    before = posterior()
    seen = np.full(CITY.grid.shape, -np.inf)
    seen[CITY.grid.cell_at(30.0, -7.0)] = 0.0  # east of the house, whose street is north
    after = before.condition({TARGET: seen})
    assert after.belief(TARGET).max() == pytest.approx(1)
    assert after.component(TARGET) != pytest.approx(before.component(TARGET), abs=0.01)
    (then,), (now,) = before.frames(TARGET), after.frames(TARGET)
    # Found to its east, "behind" makes it likelier that the house faces west.
    assert math.cos(now.mean_rad - math.pi) > math.cos(then.mean_rad - math.pi) + 0.1


def test_the_order_of_sensing_and_language_is_irrelevant():
    unseen = np.zeros(CITY.grid.shape)
    unseen[:8] = -np.inf
    one = posterior(BEHIND).condition({TARGET: unseen}).update(NEAR)
    other = posterior(BEHIND).update(NEAR).condition({TARGET: unseen})
    np.testing.assert_allclose(one.belief(TARGET), other.belief(TARGET), atol=1e-14)


def test_the_frame_posterior_is_bayes_rule_over_a_fine_grid():
    """Enumerate the frame, the cells and the components by hand."""
    seen = np.full(CITY.grid.shape, -np.inf)
    seen[2:6, 14:18] = np.log(np.random.default_rng(1).uniform(0.1, 1, (4, 4)))
    model = MIXTURE
    (summary,) = posterior().condition({TARGET: seen}).frames(TARGET)
    (term,) = ground_relations(BEHIND.relations, CITY)
    prior = model.frame_prior(term)
    psi = np.linspace(-math.pi, math.pi, 1440, endpoint=False)
    log_g = model.likelihood.log_g(term, torch.from_numpy(psi + term.offset_rad)).numpy()
    sensed = np.exp(seen.reshape(-1))
    part = prior.parts[0]
    density = np.exp(part.log_density(psi))
    prior_mass = part.weight * density / density.sum() + prior.lapse / len(psi)
    full = np.exp(log_g)  # (psi, cells)
    z_full = (prior_mass @ full).sum()
    weights = {c.name: c.weight for c in model.components}
    data = program_data({TARGET: (term,)}, CITY, model)
    (log_table,) = description_tables(Program(data, "summed"))
    tables = log_table.exp().numpy()  # with the weights of the components that apply
    total = sum(weights[n] for n in ("product", "at", "near"))
    used = weights["product"] / total * (full @ sensed) / z_full
    unused = sum(
        float(tables[i] @ sensed)
        for i, part in enumerate(model.components)
        if part.name in ("at", "near")
    )
    post = prior_mass * (used + unused)
    by_part = part.weight * density / density.sum() * (used + unused)
    assert summary.p == pytest.approx(by_part.sum() / post.sum(), abs=1e-3)
    mean = math.atan2(by_part @ np.sin(psi), by_part @ np.cos(psi))
    assert summary.mean_rad == pytest.approx(mean, abs=1e-3)


def test_a_saved_posterior_comes_back_whole(tmp_path):
    city = load_map("cleveland")
    what = said(relation("behind", "VelvetDog"))
    before, _ = infer_description(what, city, "sloop-m4")
    later = said(relation("on", "West6thSt", figure="RedBike"), targets=("RedBike",))
    before = before.update(later)
    before = before.condition({TARGET: np.where(np.eye(41) > 0, -np.inf, 0.0)})
    before.save(tmp_path / "p.nc")
    after = Posterior.load(tmp_path / "p.nc")
    assert after.city.digest == city.digest
    assert after.targets == before.targets
    for target in before.targets:
        np.testing.assert_array_equal(after.belief(target), before.belief(target))
        assert after.component(target) == before.component(target)
        assert after.frames(target) == before.frames(target)
        assert after.relations(target) == before.relations(target)


def test_a_dataset_has_named_axes():
    city = load_map("cleveland")
    data = infer_description(said(relation("near", "VelvetDog")), city, "bayes")[0].dataset
    belief = data["belief"].sel(target=TARGET)
    assert float(belief.sum()) == pytest.approx(1)
    x, y = city.centroid("VelvetDog")
    assert float(belief.sel(x=x, y=y, method="nearest")) > 10 / city.grid.size


def test_hpd_is_the_smallest_set():
    belief = posterior().belief(TARGET)
    inside = posterior().hpd(TARGET, 0.9)
    assert belief[inside].sum() >= 0.9
    assert belief[inside].sum() - belief[inside].min() < 0.9
    assert belief[inside].min() >= belief[~inside].max()


@pytest.mark.parametrize(
    ("prior", "said_why"),
    [
        (np.ones((3, 3)), r"shape \(3, 3\); expected \(21, 21\)"),
        (np.full((21, 21), np.nan), "NaN, infinite or negative"),
        (-np.ones((21, 21)), "NaN, infinite or negative"),
        (np.zeros((21, 21)), "zero everywhere"),
        ({"Bus": np.ones((21, 21))}, "'Bus' is unknown; expected one of RedCar"),
    ],
)
def test_a_prior_that_is_none_is_refused(prior, said_why):
    with pytest.raises(InputError, match=said_why):
        posterior(prior=prior)


def test_a_prior_keeps_its_zeros():
    prior = np.zeros(CITY.grid.shape)
    prior[:5] = 2.0
    belief = posterior(prior=prior).belief(TARGET)
    assert belief[5:].sum() == 0
    assert belief.sum() == pytest.approx(1)


def test_sensing_what_is_impossible_collapses_and_says_so():
    nowhere = np.full(CITY.grid.shape, -np.inf)
    with pytest.raises(BeliefCollapse, match="Nothing that was believed about 'RedCar'") as error:
        posterior().condition({TARGET: nowhere})
    assert error.value.observation == {TARGET: nowhere}


def test_sensing_takes_finite_tables_of_known_targets():
    with pytest.raises(InputError, match="NaN"):
        posterior().condition({TARGET: np.full(CITY.grid.shape, np.nan)})
    with pytest.raises(InputError, match="expected \\(21, 21\\)"):
        posterior().condition({TARGET: np.zeros((2, 2))})
    with pytest.raises(UnknownName, match="Target 'Bus' is unknown"):
        posterior().condition({"Bus": np.zeros(CITY.grid.shape)})


def test_a_relation_about_no_declared_target_is_refused():
    with pytest.raises(DescriptionError, match="'Bus', which is no target of the description"):
        posterior(said(relation("near", "House", figure="Bus")))


def test_unknown_target_lists_those_there_are():
    with pytest.raises(UnknownName, match="Target 'Bus' is unknown; expected one of RedCar"):
        posterior().belief("Bus")


def test_informed_wants_the_truth():
    with pytest.raises(InputError, match="Model 'informed' needs to be told where 'RedCar' is"):
        posterior(model="informed")


def test_repr_says_where():
    assert repr(posterior()).startswith("Posterior('block', 'mixture': RedCar near (")
