"""A belief that collapses names what excludes the target."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from sloop_ppl.errors import BeliefCollapse
from sloop_ppl.inference import infer_description
from tests.mixture import MIXTURE
from tests.scenes import TARGET, house_and_street, relation, said, symmetric_grid

CITY = house_and_street(symmetric_grid(11))
SAID = said(relation("near", "House"))
WEST = np.zeros((11, 11))
WEST[:, :4] = 1.0


def test_prior_and_sensing_that_exclude_each_other_are_named():
    believed = infer_description(SAID, CITY, prior=WEST)[0]
    seen = np.where(WEST > 0, -np.inf, 0.0)
    with pytest.raises(BeliefCollapse) as raised:
        believed.condition({TARGET: seen})
    assert str(raised.value) == (
        "Nothing that was believed about 'RedCar' is possible after this observation: its prior "
        "leaves 44 of 121 cells; what was sensed leaves 77 of 121 cells, with no cell in common; "
        "check it, or start from a prior without zeros"
    )
    assert len(raised.value.culprits) == 2
    np.testing.assert_array_equal(raised.value.prior, believed.belief(TARGET))


def test_sensing_that_excludes_every_cell_is_named_alone():
    with pytest.raises(BeliefCollapse) as raised:
        infer_description(SAID, CITY)[0].condition({TARGET: np.full((11, 11), -np.inf)})
    assert raised.value.culprits == ("what was sensed leaves 0 of 121 cells",)


@pytest.mark.parametrize("target", [TARGET, "RedBike"])
@pytest.mark.parametrize("shared", [False, True])
def test_the_target_that_has_nowhere_to_be_is_named(target, shared):
    """Whether or not the other's phrases share a front with its own."""
    what = said(
        relation("front", "House"),
        relation("behind", "House", figure="RedBike"),
        targets=(TARGET, "RedBike"),
    )
    posterior = infer_description(what, CITY, replace(MIXTURE, shared_frames=shared))[0]
    with pytest.raises(BeliefCollapse, match=f"believed about '{target}'") as raised:
        posterior.condition({target: np.full((11, 11), -np.inf)})
    assert raised.value.culprits == ("what was sensed leaves 0 of 121 cells",)


def test_phrases_that_contradict_each_other_do_not_collapse():
    """In log space a belief survives phrases that exclude each other."""
    both = said(relation("on", "House"), relation("on", "House", negated=True))
    belief = infer_description(both, CITY)[0].belief(TARGET)
    assert belief.sum() == pytest.approx(1)
    assert (belief > 0).all()
