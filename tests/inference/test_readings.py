"""Readings, alternatives and referents are summed out as the formula says, in every engine."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st
from pyro import poutine
from pyro.infer import TraceEnum_ELBO, config_enumerate
from scipy.special import logsumexp

import sloop_ppl as sloop
from sloop_ppl.inference import (
    Enumerate,
    Importance,
    Nuts,
    Posterior,
    Svi,
    infer_batch,
    infer_description,
)
from sloop_ppl.language import NOT_ON_MAP, Candidate, Reading, SpatialRelation
from sloop_ppl.models import Component, ground_relations, preset
from sloop_ppl.models.program import build
from tests.scenes import TARGET, point_city, said, symmetric_grid

GRID = symmetric_grid(9, 10.0)
PLACES = {"Ark": (-30.0, -20.0), "Bank": (30.0, 10.0), "Cafe": (0.0, 35.0)}
CITY = point_city(GRID, **PLACES)
ONE = replace(
    preset("bayes"), name="one", components=(Component("product"),), lapse=0.2, temper=0.5
)
BANKS = (Candidate("Ark", 0.5), Candidate("Bank", 0.3), Candidate(None, 0.2))
CELLS = GRID.size


def rel(word, *grounds, slots=(), **more):
    return SpatialRelation(more.pop("figure", TARGET), word, grounds, candidates=slots, **more)


def with_readings(*readings, targets=(TARGET,)):
    """Return the description of (probability, relations) pairs."""
    what = said(*readings[0][1], targets=targets)
    return replace(what, readings=tuple(Reading(p, tuple(each)) for p, each in readings))


def log_mean_one(word, grounds, model, negated=False):
    """Return log of E_psi g at each cell, g / max g for a denied word; straight from the kernel."""
    (term,) = ground_relations((rel(word, *grounds),), CITY, joint=True)
    frame = model.frame_prior_for(term)
    if frame is None:
        log_g = model.likelihood.log_g(term, term.directions(None)).reshape(-1)
    else:
        log_g = model.likelihood.log_marginal(term, frame)
    if not negated:
        return log_g.numpy()
    angles = None if frame is None else torch.arange(72, dtype=torch.float64) * math.pi / 36
    return (log_g - model.likelihood.log_g(term, term.directions(angles)).max()).numpy()


def factor(relation, chosen, model):
    """Return phi over cells, mean 1 but for what is denied or silent; `chosen`: slot -> ground."""

    def informative(grounds):
        if None in grounds or len(set(grounds)) < len(grounds):
            return np.ones(CELLS)
        g = np.exp(log_mean_one(relation.relation, grounds, model))
        return g / g.mean()

    slots = [
        [(chosen[i], 1.0)] if i in chosen else [(c.ground, c.probability) for c in relation.slot(i)]
        for i in range(len(relation.grounds))
    ]
    if relation.negated:
        held = np.ones(CELLS)
        for pairs in itertools.product(*slots):
            grounds = tuple(ground for ground, _ in pairs)
            if None not in grounds and len(set(grounds)) == len(grounds):
                g = np.exp(log_mean_one(relation.relation, grounds, model, negated=True))
                held = held * (1 - model.denial * g)
        inner = held / held.mean()
    else:
        inner = sum(
            math.prod(p for _, p in pairs) * informative(tuple(ground for ground, _ in pairs))
            for pairs in itertools.product(*slots)
        )
    return model.lapse + (1 - model.lapse) * inner


def shared_mentions(readings):
    """Return mention -> candidates of those that two phrases of a reading refer to."""
    found = {}
    for relations in readings:
        met = {}
        for r in relations:
            for i, m in enumerate(r.mentions):
                if len(r.slot(i)) > 1:
                    met.setdefault(m, []).append((r, r.slot(i)))
        for m, uses in met.items():
            if len(uses) > 1 and not all(r.negated for r, _ in uses):
                found[m] = uses[0][1]
    return found


def by_formula(description, model=ONE):
    """Return belief per target and probability per reading: sums and products, nothing shared."""
    readings = [(r.probability, r.relations) for r in description.all_readings()]
    targets = [t.id for t in description.targets]
    groups = {}
    for r in description.relations:
        if r.either is not None:
            groups.setdefault(r.either[0], []).append(r)

    def n_of(target):
        own = [r for r in description.about(target) if r.grounds != (NOT_ON_MAP,)]
        free = sum(r.either is None for r in own)
        counts = {}
        for r in own:
            if r.either is not None:
                counts.setdefault(r.either[0], {}).setdefault(r.either[1], []).append(r)
        return max(free + sum(max(map(len, c.values())) for c in counts.values()), 1)

    shared = shared_mentions([relations for _, relations in readings])
    beliefs = {t: np.zeros(CELLS) for t in targets}
    after = np.zeros(len(readings))
    for h, (pi, relations) in enumerate(readings):
        branches = {}
        for r in relations:
            if r.either is not None:
                branches.setdefault(r.either[0], set()).add(r.either[1])
        for branch in itertools.product(*(sorted(b) for b in branches.values())):
            holds = dict(zip(branches, branch, strict=True))
            for values in itertools.product(*shared.values()):
                place = dict(zip(shared, (c.ground for c in values), strict=True))
                weight = pi * math.prod(c.probability for c in values)
                weight /= math.prod(len(b) for b in branches.values())
                tables = {}
                for t in targets:
                    table = np.ones(CELLS)
                    for r in relations:
                        if r.figure != t or (r.either and holds[r.either[0]] != r.either[1]):
                            continue
                        chosen = {
                            i: place[m]
                            for i, m in enumerate(r.mentions)
                            if m in shared and len(r.slot(i)) > 1
                        }
                        table = table * factor(r, chosen, model)
                    tables[t] = table ** (n_of(t) ** -model.temper) / CELLS
                joint = weight * math.prod(table.sum() for table in tables.values())
                after[h] += joint
                for t in targets:
                    beliefs[t] += joint * tables[t] / tables[t].sum()
    total = after.sum()
    return {t: b / total for t, b in beliefs.items()}, after / total


def agrees(description, model=ONE, atol=1e-12):
    posterior, _ = infer_description(description, CITY, model)
    beliefs, after = by_formula(description, model)
    for target, belief in beliefs.items():
        np.testing.assert_allclose(posterior.belief(target).reshape(-1), belief, atol=atol)
    np.testing.assert_allclose([r.p for r in posterior.readings()], after, atol=atol)
    return posterior


def test_two_candidates_by_hand():
    """One phrase, no lapse: c_none + .5 g_Ark / mean + .3 g_Bank / mean, written out."""
    model = replace(ONE, lapse=0.0)
    posterior, _ = infer_description(said(rel("near", "Ark", slots=(BANKS,))), CITY, model)
    ark, bank = (np.exp(log_mean_one("near", (g,), model)) for g in ("Ark", "Bank"))
    phi = 0.2 + 0.5 * ark / ark.mean() + 0.3 * bank / bank.mean()
    np.testing.assert_allclose(posterior.belief(TARGET).reshape(-1), phi / phi.sum(), atol=1e-13)
    (ground,) = posterior.grounds(TARGET)
    # Alone, under a uniform prior, a phrase tells nothing of which place was meant.
    assert [c.ground for c in ground.candidates] == ["Ark", "Bank", None]
    assert [c.p for c in ground.candidates] == pytest.approx([0.5, 0.3, 0.2])


def test_what_else_was_said_tells_the_referent():
    """ "Near a bank, by the cafe": of two banks it is the one that is near the cafe."""
    what = said(rel("near", "Ark", slots=(BANKS,)), rel("near", "Cafe"))
    posterior = agrees(what)
    first, second = posterior.grounds(TARGET)
    p = {c.ground: c.p for c in first.candidates}
    assert p["Bank"] / p["Ark"] > 1.3 * (0.3 / 0.5)  # 39 m apart, the other 63 m
    assert second.candidates[0][:2] == ("Cafe", 1.0)
    assert not second.is_open


def test_sensing_tells_the_referent():
    posterior, _ = infer_description(said(rel("at", "Ark", slots=(BANKS,))), CITY, ONE)
    seen = np.zeros(GRID.shape)
    seen[GRID.y_m < 5.0, :] = -np.inf  # not in the south, where the ark is
    after = {
        c.ground: c.p for c in posterior.condition({TARGET: seen}).grounds(TARGET)[0].candidates
    }
    assert after["Bank"] > 0.5 > 0.3 > after["Ark"]


def test_either_is_the_mean_of_its_branches():
    """ "At the ark, or north of the bank near the cafe", by hand."""
    branches = (
        rel("near", "Ark", either=(0, 0)),
        rel("north", "Bank", either=(0, 1)),
        rel("near", "Cafe", either=(0, 1)),
    )
    posterior = agrees(said(*branches))
    first, second, third = (factor(r, {}, ONE) for r in branches)
    phi = (first ** (2**-0.5) + (second * third) ** (2**-0.5)) / 2
    np.testing.assert_allclose(posterior.belief(TARGET).reshape(-1), phi / phi.sum(), atol=1e-13)
    both, _ = infer_description(said(*(replace(r, either=None) for r in branches)), CITY, ONE)
    assert np.abs(both.belief(TARGET) - posterior.belief(TARGET)).sum() > 0.2


def test_a_shared_mention_is_one_place():
    pair = (
        rel("near", "Ark", slots=(BANKS,), mentions=(3,)),
        rel("behind", "Ark", slots=(BANKS,), mentions=(3,)),
    )
    together = agrees(said(*pair))
    assert together.joint.support("ground_3") == ("Ark", "Bank", NOT_ON_MAP)
    apart = agrees(said(*(replace(r, mentions=()) for r in pair)))
    assert np.abs(together.belief(TARGET) - apart.belief(TARGET)).sum() > 0.01


def test_a_mention_of_two_targets_couples_them():
    pair = (
        rel("near", "Ark", slots=(BANKS,), mentions=(0,)),
        rel("near", "Ark", slots=(BANKS,), mentions=(0,), figure="RedBike"),
    )
    posterior = agrees(said(*pair, targets=(TARGET, "RedBike")))
    assert posterior.is_coupled
    seen = np.full(GRID.shape, -np.inf)
    seen[GRID.cell_at(*PLACES["Bank"])] = 0.0  # the car is at the bank
    after = posterior.condition({TARGET: seen})
    bank = GRID.cell_at(*PLACES["Bank"])
    assert after.belief("RedBike")[bank] > 1.5 * posterior.belief("RedBike")[bank]


def test_nothing_was_read_right_gives_back_the_prior():
    """The reading "nothing" keeps pi_0 / (pi_0 + pi_1 Z_1), and its belief is the prior."""
    what = with_readings((0.6, [rel("near", "Ark"), rel("north", "Bank")]), (0.4, []))
    posterior = agrees(what)
    z = (
        (factor(what.relations[0], {}, ONE) * factor(what.relations[1], {}, ONE)) ** 0.5**0.5
    ).mean()
    assert posterior.readings()[1].p == pytest.approx(0.4 / (0.4 + 0.6 * z))
    assert posterior.readings()[1].reading.relations == ()
    given_nothing = posterior.joint.probabilities(f"{TARGET}/cell", given={"reading": 1})
    np.testing.assert_allclose(given_nothing, 1 / CELLS)
    # A single phrase has mean 1 whatever it says, so it cannot speak against being misread.
    alone, _ = infer_description(with_readings((0.6, [rel("near", "Ark")]), (0.4, [])), CITY, ONE)
    assert alone.readings()[1].p == pytest.approx(0.4)


def test_a_reading_by_itself_gives_the_belief_it_gives_alone():
    """Under the mixture of `bayes`, too: a component is normalised within each reading."""
    first = (rel("near", "Ark"), rel("behind", "Bank"))
    second = (rel("near", "Ark"), rel("left", "Bank"))
    posterior, _ = infer_description(with_readings((0.7, first), (0.3, second)), CITY)
    for h, relations in enumerate((first, second)):
        alone, _ = infer_description(said(*relations), CITY)
        got = posterior.joint.probabilities(f"{TARGET}/cell", given={"reading": h})
        np.testing.assert_allclose(got, alone.belief(TARGET).reshape(-1), atol=1e-12)


def test_all_places_of_a_denied_mention_are_denied():
    """ "Not near a bank": the product over banks of 1 - delta g / max g, whatever their shares."""
    posterior = agrees(said(rel("near", "Ark", slots=(BANKS,), negated=True)))
    belief = posterior.belief(TARGET)
    for name in ("Ark", "Bank"):
        assert belief[GRID.cell_at(*PLACES[name])] < 0.5 / CELLS
    assert belief[GRID.cell_at(*PLACES["Cafe"])] > 1 / CELLS
    weights = (Candidate("Ark", 0.1), Candidate("Bank", 0.9))
    other, _ = infer_description(
        said(rel("near", "Bank", slots=(weights,), negated=True)), CITY, ONE
    )
    np.testing.assert_allclose(other.belief(TARGET), belief, atol=1e-14)
    # "Near a bank, not north of it": it is that bank's north that is denied.
    it = {"slots": (BANKS,), "mentions": (0,)}
    agrees(said(rel("near", "Ark", **it), rel("north", "Ark", negated=True, **it)))


def test_a_place_that_is_on_no_map_says_nothing():
    gone = rel("near", NOT_ON_MAP, slots=((Candidate(None, 1.0),),))
    plain, _ = infer_description(said(rel("north", "Ark")), CITY)
    with_it, _ = infer_description(said(rel("north", "Ark"), gone), CITY)
    np.testing.assert_allclose(with_it.belief(TARGET), plain.belief(TARGET), atol=1e-14)
    assert [g.candidates[0].ground for g in with_it.grounds(TARGET)] == ["Ark", None]
    alone, _ = infer_description(said(gone), CITY)
    np.testing.assert_allclose(alone.belief(TARGET), 1 / CELLS)
    assert [i.bits for i in alone.influence(TARGET)] == [0.0]
    assert alone.predictive(TARGET) == ()


candidates = st.lists(
    st.sampled_from(["Ark", "Bank", "Cafe", None]), min_size=1, max_size=3, unique=True
).filter(lambda ids: ids != [None])


@st.composite
def phrases(draw, figure):
    word = draw(st.sampled_from(["near", "at", "north", "behind", "left"]))
    ids = draw(candidates)
    weights = np.array(draw(st.lists(st.integers(1, 9), min_size=3, max_size=3))[: len(ids)])
    slot = tuple(map(Candidate, ids, map(float, weights / weights.sum())))
    return SpatialRelation(
        figure,
        word,
        (next(i for i in ids if i is not None),),
        negated=draw(st.booleans()) and draw(st.booleans()),
        candidates=(slot,),
    )


SLOT = (Candidate("Bank", 0.6), Candidate("Cafe", 0.4))


@st.composite
def descriptions(draw):
    figures = [TARGET, "RedBike"][: draw(st.integers(1, 2))]
    made = [draw(phrases(draw(st.sampled_from(figures)))) for _ in range(draw(st.integers(1, 4)))]
    if draw(st.booleans()):  # two phrases of one mention
        word = draw(st.sampled_from(["near", "behind"]))
        figure = draw(st.sampled_from(figures))
        made.append(rel(word, "Bank", slots=(SLOT,), mentions=(0,), figure=figure))
        made.append(rel("near", "Bank", slots=(SLOT,), mentions=(0,), figure=figures[0]))
    if draw(st.booleans()):  # an alternative
        made.append(replace(draw(phrases(figures[0])), either=(0, 0)))
        made.append(replace(draw(phrases(figures[0])), either=(0, 1)))
    readings = [tuple(made)]
    while len(readings) < 3 and draw(st.booleans()):
        kept = draw(st.lists(st.sampled_from(made), unique_by=id, max_size=len(made)))
        readings.append(tuple(r for r in made if any(r is k for k in kept)))
    weights = np.arange(len(readings), 0, -1.0)
    shares = weights / weights.sum()
    return with_readings(*zip(map(float, shares), readings, strict=True), targets=tuple(figures))


@settings(max_examples=60, deadline=None)
@given(descriptions())
def test_whatever_is_left_open_the_formula_holds(description):
    agrees(description, atol=1e-10)


def everything_open():
    it = {"slots": (BANKS,), "mentions": (0,)}
    main = [
        rel("near", "Ark", **it),
        rel("behind", "Ark", **it),
        rel("left", "Bank", slots=(SLOT,), figure="RedBike"),
        rel("near", "Cafe", slots=(SLOT,), negated=True),
        rel("near", "Ark", either=(0, 0), figure="RedBike"),
        rel("north", "Bank", either=(0, 1), figure="RedBike"),
    ]
    return with_readings((0.6, main), (0.3, main[:3]), (0.1, []), targets=(TARGET, "RedBike"))


def log_joint(program, sites):
    data = {name: torch.as_tensor(np.asarray(value)) for name, value in sites.items()}
    return float(poutine.trace(poutine.condition(program, data=data)).get_trace().log_prob_sum())


def test_exact_is_brute_force_over_the_program_of_bayes():
    """Condition the program on every value of its discrete sites, a few bins for each frame."""
    what = everything_open()
    program = build(what, CITY, "bayes", frame_bins=3)
    shared = {v.name: range(len(v.support)) for v in program.data.shared}
    assert set(shared) == {"reading", "either_0", "ground_0"}
    exact = Enumerate(frame_bins=3).weigh(program.data, None)
    rng = np.random.default_rng(0)
    for i, target in enumerate(program.targets):
        data = program.data.some([i])
        alone = build(what, CITY, "bayes", frame_bins=3)
        alone = replace(alone, data=data)
        trace = poutine.trace(alone).get_trace()
        others = {*shared, "targets", f"{target}/phrases", f"{target}/cell", f"{target}/component"}
        latent = [n for n in trace.stochastic_nodes if n not in others]
        sizes = {n: (0.0, 1.0) if "lapse" in n else None for n in latent}
        sizes |= {n: range(3) for n in latent if "/frame_" in n}
        sizes |= {v.name: range(len(v.support)) for v in data.own if v.name in latent}
        assert None not in sizes.values()
        for _ in range(4):
            at = {name: int(rng.choice(values)) for name, values in shared.items()}
            k, s = int(rng.integers(2)), int(rng.integers(CELLS))
            fixed = at | {f"{target}/component": k, f"{target}/cell": s}
            each = [
                log_joint(alone, fixed | dict(zip(sizes, values, strict=True)))
                for values in itertools.product(*sizes.values())
            ]
            got = exact[i][(*at.values(), k, s)]
            got += sum(float(v.log_prior[at[v.name]]) for v in program.data.shared)
            assert got - math.log(CELLS) == pytest.approx(float(logsumexp(each)), abs=1e-9)


@pytest.mark.parametrize("frames", ["summed", "bins"])
def test_pyros_own_marginals_are_those_of_the_joint(frames):
    what = everything_open()
    program = build(what, CITY, "bayes", frames=frames, frame_bins=12)
    elbo = TraceEnum_ELBO(max_plate_nesting=0)
    marginals = elbo.compute_marginals(config_enumerate(program), lambda: None)
    engine = "exact" if frames == "summed" else Enumerate(frame_bins=12)
    posterior, _ = infer_description(what, CITY, "bayes", engine)
    for site in ("reading", "either_0", "ground_0", f"{TARGET}/cell", "RedBike/component"):
        expected = marginals[site].probs.reshape(-1).numpy()
        np.testing.assert_allclose(posterior.joint.probabilities(site), expected, atol=1e-12)


@pytest.mark.parametrize(
    "engine", [Enumerate(360), Importance(2000)], ids=["enumerate", "importance"]
)
def test_engines_that_list_or_draw_agree(engine):
    what = everything_open()
    exact, _ = infer_description(what, CITY)
    other, _ = infer_description(what, CITY, "bayes", engine, rng=np.random.default_rng(0))
    allowed = 1e-9 if isinstance(engine, Enumerate) else 0.01
    for target in exact.targets:
        assert np.abs(other.belief(target) - exact.belief(target)).sum() / 2 < allowed
        for one, same in zip(other.grounds(target), exact.grounds(target), strict=True):
            expected = {c.ground: pytest.approx(c.p, abs=allowed) for c in same.candidates}
            assert {c.ground: c.p for c in one.candidates} == expected


@pytest.mark.slow
@pytest.mark.parametrize("engine", [Nuts(100, 300), Svi()], ids=["nuts", "svi"])
def test_engines_that_move_through_frames_agree(engine):
    """NUTS within Monte Carlo error; the guide of SVI has one mode, so it is coarser."""
    main = [rel("near", "Ark", slots=(BANKS,)), rel("behind", "Bank", slots=(SLOT,))]
    what = with_readings((0.7, main), (0.3, main[:1]))
    exact, _ = infer_description(what, CITY)
    other, _ = infer_description(what, CITY, "bayes", engine, rng=np.random.default_rng(0))
    off = np.abs(other.belief(TARGET) - exact.belief(TARGET)).sum() / 2
    assert off < (0.08 if isinstance(engine, Nuts) else 0.2)
    allowed = 0.05 if isinstance(engine, Nuts) else 0.15
    assert [r.p for r in other.readings()] == pytest.approx(
        [r.p for r in exact.readings()], abs=allowed
    )


def test_the_order_of_candidates_and_readings_is_irrelevant():
    what = everything_open()
    plain, _ = infer_description(what, CITY)

    def turned(relation):
        slots = tuple(slot[::-1] for slot in relation.candidates)
        return replace(relation, candidates=slots)

    readings = [(r.probability, [turned(one) for one in r.relations]) for r in what.readings]
    other = with_readings(readings[0], *readings[:0:-1], targets=(TARGET, "RedBike"))
    posterior, _ = infer_description(other, CITY)
    for target in plain.targets:
        np.testing.assert_allclose(posterior.belief(target), plain.belief(target), atol=1e-13)
    assert [r.p for r in posterior.readings()] == pytest.approx(
        [plain.readings()[h].p for h in (0, 2, 1)]
    )


@settings(max_examples=25, deadline=None)
@given(st.floats(0.05, 0.95), st.sampled_from(["near", "north", "at"]), st.booleans())
def test_a_place_that_comes_twice_is_that_place(share, word, shared):
    """Two landmarks at one spot with parts of a candidate's weight give the same belief."""
    city = point_city(GRID, **PLACES, Twin=PLACES["Ark"])
    more = {"mentions": (0,)} if shared else {}
    twice = (
        Candidate("Ark", 0.5 * share),
        Candidate("Twin", 0.5 * (1 - share)),
        *BANKS[1:],
    )

    def belief(slot):
        pair = (rel(word, "Ark", slots=(slot,), **more), rel("near", "Ark", slots=(slot,), **more))
        return infer_description(said(*pair, rel("north", "Cafe")), city, ONE)[0].belief(TARGET)

    np.testing.assert_allclose(belief(twice), belief(BANKS), atol=1e-13)


@settings(max_examples=15, deadline=None)
@given(st.floats(0.05, 0.95))
def test_a_reading_that_comes_twice_is_that_reading(share):
    main = [rel("near", "Ark", slots=(BANKS,)), rel("behind", "Bank")]
    once, _ = infer_description(with_readings((0.6, main), (0.4, main[:1])), CITY)
    halves = with_readings((0.6, main), (0.4 * share, main[:1]), (0.4 * (1 - share), main[:1]))
    twice, _ = infer_description(halves, CITY)
    np.testing.assert_allclose(twice.belief(TARGET), once.belief(TARGET), atol=1e-13)


def test_updates_of_one_speaker_are_one_longer_description():
    first = rel("near", "Ark", slots=(BANKS,), mentions=(0,))
    again = rel("behind", "Ark", slots=(BANKS,), mentions=(0,))
    other = rel("north", "Bank", slots=(SLOT,))
    by = {"speaker": "Ann"}
    whole, _ = infer_description(replace(said(first, again, other), **by), CITY)
    start, _ = infer_description(replace(said(first, again), **by), CITY)
    grown = start.update(replace(said(other), **by))
    np.testing.assert_allclose(grown.belief(TARGET), whole.belief(TARGET), atol=1e-13)
    for one, same in zip(grown.grounds(TARGET), whole.grounds(TARGET), strict=True):
        assert [c.p for c in one.candidates] == pytest.approx([c.p for c in same.candidates])
    # Two texts are read by themselves: both "bank" and "bank" of another text may be others.
    texts = start.update(replace(said(again), **by))
    assert {"ground_0", "ground_0/text_1"} <= set(texts.joint.latents)
    stranger = start.update(replace(said(again), speaker="Bob"))
    assert {"ground_0", "ground_0[1]"} <= set(stranger.joint.latents)


def test_readings_of_several_texts_are_told_apart():
    first = with_readings((0.7, [rel("near", "Ark")]), (0.3, [rel("near", "Bank")]))
    second = with_readings((0.8, [rel("near", "Ark")]), (0.2, []))
    for speaker in ("Ann", None):
        start, _ = infer_description(replace(first, speaker=speaker), CITY, ONE)
        both = start.update(replace(second, speaker=speaker))
        assert [r.prior for r in both.readings(0)] == [0.7, 0.3]
        assert [r.prior for r in both.readings()] == [0.8, 0.2]
        assert both.readings(0)[0].p > 0.7  # the second text confirms it
        back = start.update(replace(second, speaker="Eve")).readings(0)
        assert back[0].p > 0.7


def test_the_paper_s_methods_take_what_is_most_probable():
    what = everything_open()
    certain = [
        rel("near", "Ark"),
        rel("behind", "Ark"),
        rel("left", "Bank", figure="RedBike"),
        rel("near", "Cafe", negated=True),
        rel("near", "Ark", figure="RedBike"),
    ]
    plain = said(*certain, targets=(TARGET, "RedBike"))
    for name in ("sloop", "sloop-m4", "keyword", "uniform"):
        model = preset(name)
        assert not model.sum_readings
        assert not model.sum_grounds
        got, _ = infer_description(what, CITY, name)
        expected, _ = infer_description(plain, CITY, name)
        for target in got.targets:
            np.testing.assert_array_equal(got.belief(target), expected.belief(target))
        assert [r.p for r in got.readings()] == [1.0, 0.0, 0.0]
        assert got.grounds(TARGET)[0].candidates[0][:2] == ("Ark", 1.0)
    gone = said(rel("near", "Ark"), rel("near", NOT_ON_MAP), rel("near", NOT_ON_MAP))
    near, _ = infer_description(said(rel("near", "Ark")), CITY, "sloop-m4")
    skipped, _ = infer_description(gone, CITY, "sloop-m4")
    np.testing.assert_array_equal(skipped.belief(TARGET), near.belief(TARGET))


def test_the_two_switches_ablate():
    what = everything_open()
    for sums in itertools.product([False, True], repeat=2):
        model = replace(preset("bayes"), sum_readings=sums[0], sum_grounds=sums[1])
        latents = infer_description(what, CITY, model)[0].joint.latents
        assert ("reading" in latents) == ("either_0" in latents) == sums[0]
        assert ("ground_0" in latents) == sums[1]


def test_beliefs_in_a_batch_are_those_alone():
    plain, open_ = said(rel("near", "Ark")), everything_open()
    batch = infer_batch([plain, open_, plain], CITY)
    alone, _ = infer_description(open_, CITY)
    assert list(batch[1]) == [TARGET, "RedBike"]
    np.testing.assert_array_equal(batch[1]["RedBike"], alone.belief("RedBike"))


def test_a_saved_posterior_keeps_what_was_left_open(tmp_path):
    city = sloop.load_map("cleveland", cell_m=10)
    slot = (Candidate("Ivy", 0.6), Candidate("Rumor", 0.3), Candidate(None, 0.1))
    main = [rel("near", "Ivy", slots=(slot,)), rel("behind", "Ivy", slots=(slot,))]
    what = with_readings((0.7, main), (0.2, main[:1]), (0.1, []))
    posterior, _ = infer_description(what, city)
    posterior.save(tmp_path / "p.nc")
    back = Posterior.load(tmp_path / "p.nc")
    assert back.descriptions == posterior.descriptions
    assert back.grounds(TARGET) == posterior.grounds(TARGET)
    assert back.readings() == posterior.readings()
    more = replace(said(rel("north", "Rumor")), map="cleveland")
    np.testing.assert_array_equal(
        back.update(more).belief(TARGET), posterior.update(more).belief(TARGET)
    )


def test_who_talks_long_is_cut_short_not_refused():
    """Twelve texts of one speaker with three readings each: what is least probable is left out."""
    main = [rel("near", "Ark"), rel("north", "Bank")]
    posterior, _ = infer_description(
        replace(with_readings((0.6, main), (0.3, main[:1]), (0.1, [])), speaker="Ann"), CITY
    )
    for _ in range(9):
        posterior = posterior.update(
            replace(with_readings((0.6, main), (0.3, main[:1]), (0.1, [])), speaker="Ann")
        )
    assert posterior.belief(TARGET).sum() == pytest.approx(1)
    assert sum(r.p for r in posterior.readings()) == pytest.approx(1)
