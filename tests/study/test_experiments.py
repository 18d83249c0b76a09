"""The study: what is tested on is kept apart from what is learnt from, and the results hold what they promise."""

import json
from dataclasses import replace

import jax
import numpy as np
import pytest

from fledge.errors import BadDemonstrations, OutOfRange
from fledge.learning import demonstrations
from fledge.learning.demonstrations import PAPER_ORDERS, Order, collect
from fledge.learning.policy import Policy
from fledge.learning.recipe import Recipe
from fledge.learning.training import member
from fledge.manoeuvres import Combined
from fledge.manoeuvres.paths import FAMILIES
from fledge.observation import Axes
from fledge.pilots import HumanModel, Servo
from fledge.pytrees import register
from fledge.safety import NoNet
from fledge.simulation import Crew, Rig, flight_key
from fledge.study import crossover, experiments, proving, statistics
from fledge.study.crossover import BANDS, Credibility
from fledge.study.evaluation import Score, evaluate
from fledge.study.experiments import (
    Learnt,
    Progress,
    Results,
    behind_nets,
    by_sub_task,
    composite_set,
    duel,
    learn,
    run,
)
from fledge.study.findings import (
    EXPLORATORY,
    PRIMARY,
    summarise,
)
from fledge.study.restraint import Entry
from fledge.study.setups import (
    BASIC,
    CANDIDATES,
    DEFAULT_METHOD,
    DEVELOPMENT,
    FLYING_AXES,
    FURTHER,
    PAPER_METHOD,
    SUB_TASKS,
    TEST_MANOEUVRES,
    Method,
    Setup,
    Study,
)
from fledge.world import VelocityCommand, Verdict

pytestmark = pytest.mark.slow

FIVE = ("human-combined", "dnn-combined", "primitive-paper", "primitive", "servo")
SHORT = Recipe(epochs=2, batch=None, points=2)
SLOWER = Servo(p=0.5)
"""In place of the operator in flight: one program less to compile."""
ROWS = 60
"""Flights of three seconds."""
STUDY = Study(
    "tiny",
    tuple(
        replace(setup, recipe=SHORT, pilot=SLOWER if setup.name == "human-combined" else setup.pilot)
        for setup in BASIC
        if setup.name in FIVE
    ),
    cases=4,
    manoeuvre_cases=2,
    training_seeds=2,
    rows=ROWS,
)
ORDERS = tuple(Order(order.manoeuvre, 2, 121) for order in PAPER_ORDERS)


def believe(operator, seed, flights=8, rig=Rig()):
    """In place of the measurement, which has tests of its own."""
    return (Credibility("up", *(low for low, _ in BANDS.values())),)


@pytest.fixture(scope="module")
def short():
    """Flights of three seconds, and an operator whom nobody measures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(experiments, "FLIGHT_ROWS", ROWS)
        patch.setattr(proving, "credibility", believe)
        yield


@pytest.fixture(scope="module")
def flights():
    return list(collect(ORDERS, HumanModel(), seed=0))


@pytest.fixture(scope="module")
def demos(flights):
    return by_sub_task(flights)


@pytest.fixture(scope="module")
def told(short, flights):
    """Everything that a run of the study says."""
    return list(run(STUDY, flights))


@pytest.fixture(scope="module")
def results(told):
    return told[-1]


# What is tested on


class EnoughSeen(Exception):
    """The keys are drawn; nobody needs to fly."""


@pytest.mark.parametrize("seed", [0, 1, 2**40])
def test_no_two_flights_of_a_study_share_chance(seed, monkeypatch):
    """Tests, development, demonstrations and the operator's credibility: all keys differ, and what is made of them."""
    seen = []

    def note(*key):
        seen.append((key[1], flight_key(*key)))
        return seen[-1][1]

    def stop(*anything, **named):
        raise EnoughSeen

    for module in (experiments, proving, demonstrations, crossover):
        monkeypatch.setattr(module, "flight_key", note)
    for module in (demonstrations, crossover):
        monkeypatch.setattr(module, "fly", stop)
    monkeypatch.setattr(experiments, "learn", stop)
    study = Study("any", BASIC, 30, 20, 1, development_cases=30, seed=seed)
    proving.test_cases(study)
    for flown in (
        lambda: list(experiments.choose(study, {}, Rig())),
        lambda: list(collect([Order(order.manoeuvre, 20, 400) for order in PAPER_ORDERS], Servo(), seed)),
        lambda: crossover.credibility(HumanModel(), seed),
    ):
        with pytest.raises(EnoughSeen):
            flown()
    purposes = {purpose for purpose, _ in seen}
    assert purposes == {"test", "development", "demonstration", "crossover"}
    # The operator flies both sub-tasks with the same eight keys: that is one purpose.
    keys = {purpose: {key for p, key in seen if p == purpose} for purpose in purposes}
    everything = [key for some in keys.values() for key in some]
    assert len(set(everything)) == len(everything)
    assert len(everything) == 30 + 3 * 20 + 30 + 4 * 20 + 8
    states = {
        tuple(np.random.SeedSequence(list(chance)).generate_state(4))
        for key in everything
        for chance in (key, (*key, 1))
    }
    assert len(states) == 2 * len(everything)
    assert flight_key(seed + 1, "test", "combined", 0) not in everything


def test_the_paths_of_tests_are_held_out():
    """No demonstration, and no flight on which the method was chosen, follows a path of a test family."""
    trained = {f for order in PAPER_ORDERS for f in getattr(order.manoeuvre, "families", ())}
    trained |= set(Combined().families)
    chosen_on = set(DEVELOPMENT.families)
    tested = {f for manoeuvre in TEST_MANOEUVRES for f in getattr(manoeuvre, "families", ())}
    assert tested and not tested & (trained | chosen_on)
    assert trained | chosen_on | tested == set(FAMILIES)
    assert [m.name for m in TEST_MANOEUVRES][0] == "combined"
    assert {m.name for m in TEST_MANOEUVRES} == {order.manoeuvre.name for order in PAPER_ORDERS}


# What is learnt from


class Forbidden(dict):
    """Demonstrations of which those of Combined must not be touched."""

    def __getitem__(self, name):
        assert name != "combined", "a set-up that learns from sub-tasks asked for Combined"
        return super().__getitem__(name)


@pytest.mark.parametrize("setup", [s for s in (*CANDIDATES, *BASIC, *FURTHER) if s.trained_on == "sub-tasks"])
def test_no_combined_demonstration_reaches_a_method_that_learns_from_sub_tasks(setup, demos):
    composite, delay = composite_set("sub-tasks", setup.method, Forbidden(demos))
    assert composite.names == tuple(task.name for task in SUB_TASKS)
    pure, alone = composite_set(
        "sub-tasks", setup.method, {n: d for n, d in demos.items() if n != "combined"}
    )
    assert (composite.digest(), delay) == (pure.digest(), alone)
    assert len(composite.states) == 3 * 121 - 6 * delay


def absurd(flights):
    """The same flights, but those of Combined full of numbers that would ruin any training."""
    for flight in flights:
        if flight.manoeuvre != "combined":
            yield flight
        else:
            episode = jax.tree.map(lambda leaf: 1e6 + 1e5 * np.arange(len(leaf)), flight.episode)
            yield replace(flight, episode=episode)


def test_absurd_combined_demonstrations_change_nothing_for_sub_tasks(flights, results, short):
    """A whole study, to the last bit: scores, curves, weights."""
    some = ("human-combined", "primitive")
    study = replace(STUDY, setups=tuple(setup for setup in STUDY.setups if setup.name in some))
    *_, poisoned = run(study, list(absurd(flights)))
    for name in some:
        assert poisoned.summary["setups"][name] == results.summary["setups"][name]
    jax.tree.map(
        np.testing.assert_array_equal,
        poisoned.setups["primitive"].policy.weights,
        results.setups["primitive"].policy.weights,
    )
    assert poisoned.summary["non_inferiority"] == results.summary["non_inferiority"]


def test_a_set_up_learns_what_its_method_says(results, demos):
    for name, trained_on, method in (
        ("dnn-combined", "combined", PAPER_METHOD),
        ("primitive-paper", "sub-tasks", PAPER_METHOD),
        ("primitive", "sub-tasks", DEFAULT_METHOD),
    ):
        composite, delay = composite_set(trained_on, method, demos)
        learnt = results.setups[name]
        assert learnt.learning["rows"] == len(composite.states)
        assert (learnt.learning["fill"], learnt.learning["delay_rows"]) == (method.fill, delay)
        assert learnt.policy.inputs == composite.inputs == method.inputs
        assert learnt.policy.contract.data == composite.digest()
        assert len(learnt.policy.weights[0]) == STUDY.training_seeds
        assert learnt.curve.names == composite.names


def test_yaw_is_nobody_s_and_the_delay_is_shared():
    """A given delay is used as it is; yaw stays masked in, at zero (D1)."""
    rng = np.random.default_rng(0)
    data = {
        task.name: demonstrations.Demonstrations.of(
            (rng.normal(size=(30, 11)), rng.normal(size=(30, n))), task.name
        )
        for task, n in zip(SUB_TASKS, (2, 1, 1), strict=True)
    }
    composite, delay = composite_set("sub-tasks", Method("mask", (2, 3), 3), data)
    assert delay == 3 and composite.inputs == (2, 3)
    assert not composite.actions[:, 3].any() and composite.mask[:, 3].all()


def pretend(monkeypatch, seen):
    """Training that only takes notes."""

    def train(composite, recipe, keys):
        seen.append((composite, keys))
        yield type("Checkpoint", (), {"epoch": 1, "curve": None})()

    monkeypatch.setattr(experiments, "train", train)
    monkeypatch.setattr(experiments, "policies", lambda *anything: None)


def test_matched_set_ups_learn_from_as_many_rows(monkeypatch, demos, flights):
    """Fewer rows of the sub-tasks; more Combined flights, by the same operator, where there are too few (D14)."""
    seen, ordered = [], []
    pretend(monkeypatch, seen)
    less = Setup("less", "", trained_on="sub-tasks", rows=121)
    *_, learnt = learn(less, Forbidden(demos), STUDY, Rig())
    assert abs(len(seen[0][0].states) - 121) <= 3 and learnt.learning["rows"] == len(seen[0][0].states)
    assert set(seen[0][0].subtask) == {0, 1, 2}

    def fly_more(orders, pilot, seed, rig):
        ordered.extend(orders)
        return [flight for flight in flights if flight.manoeuvre == "combined"] * 3

    monkeypatch.setattr(experiments, "collect", fly_more)
    *_, learnt = learn(Setup("more", "", trained_on="combined", rows=360), demos, STUDY, Rig())
    (order,) = ordered
    assert (order.manoeuvre, order.rows) == (Combined(), 360)
    assert abs(len(seen[1][0].states) - 360) <= 6
    *_, learnt = learn(Setup("enough", "", trained_on="combined", rows=60), demos, STUDY, Rig())
    assert len(ordered) == 1 and abs(len(seen[2][0].states) - 60) <= 2


def test_every_training_seed_has_a_key_of_its_own(monkeypatch, demos):
    seen = []
    pretend(monkeypatch, seen)
    setup = Setup("any", "", trained_on="sub-tasks")
    for study in (replace(STUDY, training_seeds=20), replace(STUDY, training_seeds=20, seed=1)):
        list(learn(setup, demos, study, Rig()))
    list(learn(replace(setup, seeds=1), demos, STUDY, Rig()))
    first, second, one = (keys for _, keys in seen)
    assert len(set(first + second)) == 40
    assert one == first[:1]


def test_methods_are_chosen_on_development_flights(monkeypatch, demos, short):
    """Each candidate on the same flights of the training families; nothing of Combined is learnt from."""
    flown = []

    def watch(cases, crew, keys, rig, team):
        flown.append((cases, keys))
        ones = np.ones((3, len(cases)))
        return Score(*(ones * (i + len(flown)) for i in range(len(Score.names())))), None

    def fake(setup, data, study, rig):
        assert setup.trained_on == "sub-tasks"
        composite_set(setup.trained_on, setup.method, Forbidden(data))
        nothing = np.zeros((3, 1, 4), np.float32)
        policy = Policy((nothing,), (nothing[:, 0],), nothing[:, 0, :1], nothing[:, 0, :1] + 1.0, (0,), 11)
        yield Learnt(policy, None, {"fill": setup.method.fill})

    monkeypatch.setattr(experiments, "evaluate", watch)
    monkeypatch.setattr(experiments, "learn", fake)
    rows = list(experiments.choose(replace(STUDY, development_cases=3), demos, Rig()))
    assert [row["name"] for row in rows] == [setup.name for setup in CANDIDATES]
    assert [row["fill"] for row in rows] == [setup.method.fill for setup in CANDIDATES]
    assert rows[0]["distance_rmse_px"] == 2.0 and rows[1]["distance_rmse_px"] == 3.0
    assert {len(cases) for cases, _ in flown} == {3}
    for cases, keys in flown:
        assert keys == flown[0][1]
        np.testing.assert_array_equal(cases[0].plan.track.x, flown[0][0][0].plan.track.x)
    assert {len({setup.name for setup in CANDIDATES}), len(rows)} == {len(CANDIDATES)}
    fast = [setup.method for setup in CANDIDATES if setup.recipe == Recipe.fast()]
    assert DEFAULT_METHOD in fast and PAPER_METHOD in fast


# What comes out


def test_the_study_says_how_far_it_is(told):
    *progress, last = told
    assert isinstance(last, Results)
    assert all(isinstance(event, Progress) for event in progress)
    assert all(0 <= event.done <= event.total for event in progress)
    whole = [event for event in progress if ":" not in event.stage]
    assert [event.stage for event in whole] == [*(s.name for s in STUDY.setups), "operator", "statistics"]
    assert [event.done for event in whole] == list(range(whole[0].total))
    assert {event.total for event in whole} == {len(STUDY.setups) + 2}
    training = [event for event in progress if event.stage == "primitive: training"]
    assert [(event.done, event.total) for event in training] == [(1, 2), (2, 2)]


def test_results_hold_what_they_promise(results):
    """The contract of results.json."""
    summary = json.loads(json.dumps(results.summary, allow_nan=False))
    assert set(FIVE) == set(summary["setups"])
    for name, setup in summary["setups"].items():
        seeds = STUDY.training_seeds if setup["trained_on"] else 1
        assert setup["flights"] == seeds * STUDY.cases
        for metric in ("distance", "radius"):
            assert set(setup[metric]) == {"mean", "sd"}
            assert setup[metric]["mean"] > 0.0 and setup[metric]["sd"] > 0.0
        for metric in ("distance_rmse_px", "radius_rmse_px", "smoothness"):
            assert isinstance(setup[metric], float) and setup[metric] >= 0.0
        assert 0.0 <= setup["in_view"] <= 1.0
        assert (
            (setup["curve"] is None) == (setup["learning"] is None) == (name in ("human-combined", "servo"))
        )
        assert np.shape(setup["scores"]["distance"]) == (seeds, STUDY.cases)
        assert {name: one["flights"] for name, one in setup["manoeuvres"].items()} == {
            m.name: seeds * (STUDY.cases if m.name == "combined" else STUDY.manoeuvre_cases)
            for m in TEST_MANOEUVRES
        }
    for comparison in summary["comparisons"]:
        assert {"a", "b", "metric", "difference", "interval", "p", "p_holm", "effect_size"} <= set(comparison)
        low, high = comparison["interval"]
        assert low <= high
        assert 0.0 < comparison["p"] <= comparison["p_holm"] <= 1.0
    assert summary["version"] and summary["seed"] == STUDY.seed
    settings = summary["settings"]
    assert (settings["cases"], settings["training_seeds"]) == (4, 2)
    assert settings["demonstrations"] == {
        order.manoeuvre.name: {"episodes": 2, "rows": 121} for order in ORDERS
    }
    assert not set(settings["families"].pop("test")) & set(sum(settings["families"].values(), []))
    assert "synthetic operator" in summary["operator"]["sentence"]
    assert summary["development"] is None


def test_a_summary_is_of_its_scores(results):
    """Means and deviations over flights of what is stored beside them."""
    for name, setup in results.summary["setups"].items():
        scores = {metric: np.array(values) for metric, values in setup["scores"].items()}
        assert setup["distance"] == pytest.approx({
            "mean": scores["distance"].mean(),
            "sd": scores["distance"].std(ddof=1),
        })
        assert setup["radius"]["mean"] == pytest.approx(scores["radius"].mean())
        assert setup["distance_rmse_px"] == pytest.approx(scores["distance_rmse"].mean())
        assert setup["distance_integral_px_s"] == pytest.approx(scores["distance"].mean() * ROWS / 20.0)
        kept = results.setups[name].scores["combined"]
        np.testing.assert_array_equal(kept.in_view, scores["in_view"])


def test_every_set_up_flies_the_declared_cases(results, short):
    """Flown outside the study, the servo scores what the study says."""
    cases, keys = proving.test_cases(STUDY)
    scores, first = evaluate(cases, Crew(Servo(), Axes.of(FLYING_AXES)), keys)
    flown = results.setups["servo"]
    start = 0
    for manoeuvre in TEST_MANOEUVRES:
        part = flown.scores[manoeuvre.name]
        stop = start + part.distance.shape[1]
        np.testing.assert_array_equal(part.distance, scores.distance[:, start:stop])
        start = stop
    assert start == len(cases)
    jax.tree.map(np.testing.assert_array_equal, flown.sample.episode, first)
    assert (flown.sample.rows, flown.sample.pilot, flown.sample.arena) == (ROWS, "servo", cases[0].plan.arena)


def test_the_same_study_twice_gives_the_same_results(flights, results, short):
    """To the last bit, training included."""
    *_, again = run(STUDY, flights)
    assert again.summary == results.summary
    assert json.dumps(again.summary) == json.dumps(results.summary)


def test_comparisons_are_those_fixed_in_advance(results):
    found = results.summary["comparisons"]
    primary = [(c["a"], c["b"], c["metric"]) for c in found if c["family"] == "primary"]
    assert primary == [(a, b, m) for a, b in PRIMARY for m in ("distance_rmse", "radius_rmse")]
    exploratory = {(c["a"], c["b"]) for c in found if c["family"] == "exploratory"}
    assert exploratory == {(a, b) for a, b in EXPLORATORY if a in FIVE and b in FIVE}
    for family in ("primary", "exploratory"):
        own = [c for c in found if c["family"] == family]
        assert [c["p_holm"] for c in own] == list(statistics.holm([c["p"] for c in own]))
    means = {name: setup["distance_rmse_px"] for name, setup in results.summary["setups"].items()}
    for c in found:
        if c["metric"] == "distance_rmse":
            assert c["difference"] == pytest.approx(means[c["a"]] - means[c["b"]], rel=1e-5, abs=1e-5)
    assert [one["metric"] for one in results.summary["non_inferiority"]] == ["distance_rmse", "radius_rmse"]


def test_a_study_without_the_paper_s_set_ups_has_results_too(results, demos):
    """A researcher's own rows in the table: what cannot be compared is left out."""
    some = {name: results.setups[name] for name in ("servo", "dnn-combined")}
    summary = summarise(STUDY, some, [], None, demos, Rig())
    assert set(summary["setups"]) == set(some)
    assert summary["comparisons"] == [] and summary["non_inferiority"] == []


def test_what_the_paper_s_own_table_supports(results):
    """Welch on the printed numbers: one p below 0.05, none after Holm."""
    table = {(row["a"], row["b"], row["metric"]): row for row in results.summary["paper"]["welch"]}
    assert len(table) == 6
    assert table["dnn-combined", "primitive", "radius"]["p"] == pytest.approx(0.042, abs=0.002)
    assert sum(row["p"] < 0.05 for row in table.values()) == 1
    assert min(row["p_holm"] for row in table.values()) > 0.2
    assert all(row["p"] <= row["p_holm"] <= 1.0 for row in table.values())


# Sizes and refusals


def test_studies_grow():
    quick, brief, full = (Study.of(mode, seed=3) for mode in ("quick", "brief", "full"))
    assert [study.mode for study in (quick, brief, full)] == ["quick", "brief", "full"]
    assert all(study.seed == 3 for study in (quick, brief, full))
    assert quick.training_seeds < brief.training_seeds < full.training_seeds
    # From here on, p speaks of new trainings, too.
    assert brief.training_seeds >= statistics.SEEDS_NEEDED
    assert set(FIVE) <= {setup.name for setup in quick.setups} == {setup.name for setup in brief.setups}
    assert {setup.name for setup in full.setups} == {setup.name for setup in BASIC + FURTHER}
    assert quick.development_cases == brief.development_cases == 0 < full.development_cases
    assert quick.cases == brief.cases == full.cases
    with pytest.raises(OutOfRange, match="seed is -1"):
        Study.of("quick", seed=-1)


def test_set_ups_are_complete_and_have_names_of_their_own():
    names = [setup.name for setup in BASIC + FURTHER]
    assert len(set(names)) == len(names)
    assert {name for pair in (*PRIMARY, *EXPLORATORY) for name in pair} <= set(names)
    for setup in BASIC + FURTHER:
        assert (setup.pilot is None) != (setup.trained_on is None)
        assert setup.recipe.checked() and setup.title
    study = Study.of("brief")
    for setup in FURTHER:
        assert study.seeds_of(setup) == (setup.seeds or study.training_seeds)


@pytest.mark.parametrize("missing", ["climb", "combined"])
def test_a_missing_manoeuvre_is_named(flights, missing):
    some = [flight for flight in flights if flight.manoeuvre != missing]
    with pytest.raises(BadDemonstrations) as caught:
        next(run(STUDY, some))
    message = str(caught.value)
    assert "\n" not in message
    assert f"no demonstrations of {missing};" in message
    assert all(name in message for name in {flight.manoeuvre for flight in some})


def test_only_what_a_set_up_needs_must_be_there(flights):
    climb = [flight for flight in flights if flight.manoeuvre == "climb"]
    combined = [flight for flight in flights if flight.manoeuvre == "combined"]
    rest = [flight for flight in flights if flight.manoeuvre not in ("climb", "combined")]
    assert set(by_sub_task(climb + rest, "sub-tasks")) == {task.name for task in SUB_TASKS}
    assert set(by_sub_task(combined, "combined")) == {"combined"}
    with pytest.raises(
        BadDemonstrations, match="no demonstrations of climb, descend, fixed-altitude; found none"
    ):
        by_sub_task([], "sub-tasks")
    with pytest.raises(BadDemonstrations, match="no demonstrations of combined"):
        by_sub_task(climb + rest, "combined")


# Duels


def test_a_duel_compares_the_first_with_the_others(short):
    """On the study's test cases; against itself a pilot wins nothing."""
    count, done = STUDY.cases + 3 * STUDY.manoeuvre_cases, []
    pilots = {"a": Servo(), "b": SLOWER, "c": Servo(d=0.0), "d": Servo()}
    found = duel(pilots, TEST_MANOEUVRES[0], count, 0, done.append)
    assert done == [0, 1, 2, 3, 4]
    assert list(found["entries"]) == list(pilots)
    assert all(entry["flights"] == count for entry in found["entries"].values())
    assert {(c["a"], c["b"]) for c in found["comparisons"]} == {("a", "b"), ("a", "c"), ("a", "d")}
    assert {c["metric"] for c in found["comparisons"]} == {"distance_rmse", "radius_rmse", "in_view"}
    for c in found["comparisons"]:
        assert c["p_holm"] >= c["p"]
        if c["metric"] == "distance_rmse":
            entries = found["entries"]
            wanted = entries[c["a"]]["distance_rmse_px"] - entries[c["b"]]["distance_rmse_px"]
            assert c["difference"] == pytest.approx(wanted, rel=1e-4, abs=1e-6)
        if c["b"] == "d":
            assert (c["difference"], c["p"]) == (0.0, 1.0)
    json.dumps(found, allow_nan=False)
    (alone,) = duel({"a": Servo()}, TEST_MANOEUVRES[0], count, 0)["entries"].values()
    assert alone == found["entries"]["a"]


def test_pilots_may_duel_behind_a_net(short):
    """One that lets nobody fly: all see the UGVs leave."""

    class Anchor(NoNet):
        def filter(self, memory, world, commands):
            hover = VelocityCommand.hover()
            return memory, tuple(Verdict(hover, 1.0, 1.0, 0.0) for _ in (commands.uav, *commands.ugvs))

    pilots = {"a": Servo(), "b": SLOWER}
    held = duel(pilots, TEST_MANOEUVRES[0], 3, 0, net=Anchor())["entries"]
    assert held["a"]["distance"] == held["b"]["distance"]
    assert held["a"]["effort"] != held["b"]["effort"]


# Nets


def test_the_default_policy_and_the_operator_fly_behind_every_net(results, monkeypatch):
    flown = []

    def fly(name, pilot, nets, flights, rig):
        flown.append((name, pilot, tuple(nets), tuple(flights)))
        yield from (Entry(name, net, {}) for net in nets)

    monkeypatch.setattr(experiments, "examine", fly)
    monkeypatch.setattr(experiments, "summarise_nets", lambda entries, rows, seed: (entries, rows, seed))
    study = replace(STUDY, nets=("none", "paper"), net_cases=2, lab_cases=1, operator_behind_nets=True)
    *told, (entries, rows, seed) = behind_nets(study, results.setups, Rig())
    assert [event.done for event in told] == [0, 1, 2, 3, 4] and {event.total for event in told} == {4}
    assert [(one.pilot, one.net) for one in entries][::2] == [
        ("primitive", "none"),
        ("human-combined", "none"),
    ]
    assert (rows, seed) == (ROWS, STUDY.seed)
    (_, policy, nets, kinds), (_, operator, _, fewer) = flown
    assert policy.contract is None and policy.weights[0].ndim == 2 and isinstance(operator, HumanModel)
    assert nets == ("none", "paper") and kinds == ("combined", "reversed", "lab") and fewer == kinds[:2]


def test_networks_are_alike_but_for_their_numbers(results):
    """Else what was compiled before they learnt would be compiled anew."""
    register(Policy.blank(()))
    blank = jax.tree.map(np.shape, Policy.blank(DEFAULT_METHOD.inputs))
    policies = [one.policy for one in results.setups.values() if one.policy is not None]
    assert len(policies) > 2
    for policy in policies:
        assert jax.tree.map(np.shape, replace(member(policy, 0), contract=None)) == blank


def test_a_study_without_nets_says_so(results):
    assert results.summary["nets"] is None
    assert not list(behind_nets(STUDY, results.setups, Rig()))
