"""The commands: a function each, whose signature is its options and whose docstring is its help.

The work is done in `logbook`, `apprenticeship` and `archive`, which put files between the steps of the method. They are
imported when a command runs, so that the help is there at once. A line of help has at most 80 characters.
"""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Literal

from tyro.conf import Positional

from fledge import console, lookup
from fledge.commands import doctor, fly
from fledge.commands.options import (
    Cases,
    Contestants,
    Episodes,
    Epochs,
    Factor,
    File,
    Files,
    Flag,
    Folder,
    Hall,
    Minutes,
    Name,
    Names,
    NewFile,
    Seed,
    Steps,
)
from fledge.errors import FledgeError
from fledge.report import tables


def reproduce(
    quick: Flag = False,
    full: Flag = False,
    seed: Seed = 0,
    out: Folder = Path("report"),
    json: NewFile = None,
) -> None:
    """Run the paper's whole study: demonstrate, fuse, train, fly, compare, report.

    Leaves index.html, results.json, figures, policies, demonstrations, flights.

    Trains a few networks of each set-up, which takes minutes; or else see below.

    Args:
        quick: Train one network of each set-up, leave out the nets; a minute.
        full: Train 20 of every set-up there is, some for 10000 epochs; half an hour.
        seed: Another seed: other demonstrations, networks and test cases.
        out: Where everything goes.
        json: Write the results to this file, too; with -, to standard output and nothing else there.
    """
    if quick and full:
        raise FledgeError("--quick and --full exclude each other: give one, or neither")
    from fledge.learning.demonstrations import PAPER_ORDERS
    from fledge.pilots import HumanModel
    from fledge.report.study import write_report
    from fledge.runs import archive, logbook
    from fledge.study.proving import Bystanders
    from fledge.study.setups import Study

    study = Study.of("full" if full else "quick" if quick else "brief", seed)
    times: dict[str, float] = {}
    with Bystanders(study) as bystanders:
        with _timing(times, "demonstrations"):
            flights = logbook.fill(out / "demonstrations", PAPER_ORDERS, HumanModel(), seed)
        with _timing(times, "study"):
            results = archive.conduct(study, flights, bystanders)
    summary = archive.store(out, results, times)
    page = write_report(out)
    title = f"{study.cases} Combined test flights; training seeds: {study.training_seeds}"
    primary = [one for one in summary["comparisons"] if one["family"] == "primary"]
    console.show(
        summary,
        json,
        tables.scores(title, summary["setups"]),
        *tables.comparisons(primary),
        tables.operator(summary["operator"]),
        f"report: {page}",
    )


def demonstrate(
    out: Folder = Path("demos"),
    manoeuvre: Names = (),
    episodes: Episodes = None,
    minutes: Minutes = None,
    pilot: Name = "human-model",
    seed: Seed = 0,
    json: NewFile = None,
) -> None:
    """Let a pilot fly demonstrations, and store each flight as one MCAP file.

    Without options: the paper's four manoeuvres, with its episodes and rows.

    Interrupted and run again, it goes on where it was.

    Args:
        out: Where the flights go.
        manoeuvre: What to fly, by name or as package.module:Name of your own; the paper's four by default.
        episodes: Flights of each manoeuvre; the paper's numbers by default.
        minutes: Length of each flight, 0.1 to 60; by default the paper's rows are shared out.
        pilot: Who flies: human-model, servo, or package.module:Name of your own.
        seed: Another seed: other flights.
        json: Write a summary to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.manoeuvres import MANOEUVRES
    from fledge.runs import logbook

    chosen = [lookup.manoeuvre(name) for name in dict.fromkeys(manoeuvre)] or list(MANOEUVRES)
    orders = logbook.orders(chosen, episodes, minutes)
    flights = logbook.fill(out, orders, lookup.pilot(pilot), seed)
    rows = {order.manoeuvre.name: order.rows for order in orders}
    console.show(
        {"folder": str(out), "pilot": pilot, "seed": seed, "flights": len(flights), "rows": rows},
        json,
        f"{out}: flown by {pilot}, " + ", ".join(f"{name} {count:,} rows" for name, count in rows.items()),
    )


def train(
    demos: Annotated[Folder, Positional],
    setup: Name = "primitive",
    recipe: Literal["fast", "paper"] = "fast",
    epochs: Epochs = None,
    out: File = Path("policy.onnx"),
    seed: Seed = 0,
    resume: Flag = False,
    include_takeovers: Flag = False,
    json: NewFile = None,
) -> None:
    """Fuse demonstrations (Algorithm 1), train a network, store it as one ONNX file.

    The set-ups learn
    - primitive: from fixed-altitude, climb and descend, by the default method
    - primitive-zero: likewise, but with zeros for what was not demonstrated
    - primitive-paper: likewise, by the paper's method
    - dnn-combined: from combined

    Args:
        demos: A folder that `fledge demonstrate` filled.
        setup: What to learn from, and by which method.
        recipe: How to optimise: fast takes seconds, paper 10000 epochs of all rows at once.
        epochs: Other than the recipe's number of them.
        out: The policy. Until it is done, its checkpoint stands beside it.
        seed: Another seed: other initial weights, another order of rows.
        resume: Go on from the checkpoint that an interrupted training left.
        include_takeovers: Learn from people who took over, too: from the cockpit's flights in demos/flights.
        json: Write the losses to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.runs import apprenticeship, logbook

    plan, chosen = lookup.setup(setup), apprenticeship.recipe(recipe, epochs)
    taken_over = logbook.taken_over(demos) if include_takeovers else []
    lesson = apprenticeship.Lesson.of(logbook.read(demos), plan, chosen, seed, taken_over)
    curve = apprenticeship.learn(lesson, out, resume)
    rows, last = len(lesson.composite.states), float(curve.training[-1, 0])
    held_out = float(curve.validation[-1, 0])
    console.show(
        {
            "policy": str(out),
            "setup": setup,
            "rows": rows,
            "delay_rows": lesson.delay,
            **lesson.settings,
            "epochs": curve.epochs.tolist(),
            "training_loss": curve.training[:, 0].tolist(),
            "held_out_loss": curve.validation[:, 0].tolist(),
        },
        json,
        f"{out}: {setup} on {rows:,} rows; mean squared error {last:.4f}, held out {held_out:.4f}",
    )


def evaluate(
    policies: Contestants,
    manoeuvre: Name = "combined",
    net: Name = "none",
    cases: Cases = 200,
    seed: Seed = 0,
    json: NewFile = None,
) -> None:
    """Fly policies and pilots on the same cases; compare the first with the others.

    Every case is a flight of 60 s with a path, wind and noise of its own.

    The paper's four manoeuvres are flown along paths that no demonstration used.

    Args:
        policies: ONNX files, and names of pilots: human-model, servo, or package.module:Name of your own.
        manoeuvre: What the UGVs do: combined, fixed-altitude, climb, descend, or package.module:Name of your own.
        net: Behind which safety net: none, paper, stop-tube, ..., or package.module:Name of your own.
        cases: How many flights each of them flies.
        seed: Another seed: other cases.
        json: Write scores and comparisons to this file, too; with -, to standard output and nothing else there.
    """
    if not policies:
        raise FledgeError("nobody to evaluate: valid are ONNX files and names of pilots, one or more")
    from fledge.study.experiments import duel

    test, crews = lookup.test(manoeuvre), {name: lookup.contestant(name) for name in policies}
    behind = lookup.net(net)
    with console.progress() as bar:

        def done(number: int) -> None:
            bar.update("evaluation", number, len(crews))

        found = duel(crews, test, cases, seed, done, net=behind)
    scores = tables.scores(f"{test.name}, net {net}: {cases} flights of 60 s each", found["entries"])
    summary = {"manoeuvre": test.name, "net": net, "cases": cases, "seed": seed, **found}
    console.show(summary, json, scores, *tables.comparisons(found["comparisons"]))


def replay(flight: Annotated[File, Positional], out: NewFile = None, json: NewFile = None) -> None:
    """Draw a stored flight, and say how good it was.

    The log of a lab flight is flown once more, and compared byte for byte.

    The file itself opens in Foxglove, too.

    Args:
        flight: An MCAP file.
        out: The picture: .png, .svg or .pdf, or .gif for an animation; a .png beside the flight by default.
        json: Write the flight's scores to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.lab.shell.rerun import is_log
    from fledge.report.replay import draw_flight
    from fledge.simulation import Rig
    from fledge.storage import read_flight
    from fledge.study.evaluation import Score, score

    stored, again = fly.rerun(flight) if is_log(flight) else (read_flight(flight), None)
    if stored is None:
        console.show({"again": again}, json)
        return
    picture = draw_flight(stored, out or flight.with_suffix(".png"))
    scored = score(stored.episode, replace(Rig(), lens=stored.lens, ideal_radius=stored.ideal_radius))
    scores = {name: float(getattr(scored, name)) for name in Score.names()}
    about = {name: getattr(stored, name) for name in ("manoeuvre", "pilot", "net", "seed", "case", "rows")}
    title = "{manoeuvre} by {pilot}, net {net}, seed {seed}, case {case}, {rows} rows".format(**about)
    summary = about | {"scores": scores, "picture": str(picture)} | ({"again": again} if again else {})
    console.show(summary, json, tables.flight(title, scores), f"picture: {picture}")


def falsify(
    net: Name = "stop-tube",
    steps: Steps = 1_000_000,
    policy: Files = (),
    arena: Hall = None,
    factor: Factor = 1.0,
    seed: Seed = 0,
    out: Folder = Path("violations"),
    json: NewFile = None,
) -> None:
    """Attack a safety net in the simulator, and count what it let happen.

    A flight is 10 s of attack on all vehicles, then 10 s of leading one away.

    What is counted
    - contacts: flights in which a hull touched something
    - dead-locks: flights whose vehicle was not let out, though there was a way
    - breaches: flights in which a centre came within 0.5 m of something
    - false alarms: times the net stepped in where nothing would have been touched

    Args:
        net: What is attacked: stop-tube, barrier, conformal, paper, paper-repaired, none, or package.module:Name.
        steps: To fly in all, at 100 a second; 2000 make a flight.
        policy: ONNX files of policies that fly, too; by default two are trained first.
        arena: Where to fly: square, lab, or a TOML file of your own; random arenas by default.
        factor: By which delays, errors and pushes overstep the contract, 0 to 5; up to 1 is within it.
        seed: Another seed: other attacks.
        out: Where flights go that should not have happened, a few of every family.
        json: Write what was found to this file, too; with -, to standard output and nothing else there.
    """
    from fledge.falsification.campaign import Campaign, checked, summary
    from fledge.falsification.scenarios import Terms
    from fledge.runs import evidence
    from fledge.study import berth

    terms = Terms(factor=factor, arena=lookup.arena(arena) if arena else None)
    campaign = checked(Campaign(lookup.net(net), net, steps, seed, terms=terms))
    if terms.arena:
        console.note(berth.announced(net, campaign.net, terms.arena))
    policies = {str(path): lookup.policy(path) for path in policy}
    campaign = replace(campaign, policies=policies or evidence.train(seed))
    toll = evidence.gather(campaign)
    found = summary(campaign, toll) | {"violations": evidence.store(out, campaign, toll)}
    title = f"{net} under attack: {found['flights']:,} flights, {found['steps']:,} steps, seed {seed}"
    console.show(found, json, tables.attacks(title, found), *evidence.sentences(found))


def examine(json: NewFile = None) -> None:
    """Say what fledge finds on this machine, what is missing, what to type.

    Exits with 1 if something is missing that fledge needs.

    Args:
        json: Write the findings to this file, too; with -, to standard output and nothing else there.
    """
    findings = doctor.examine()
    well = all(finding.ok or not finding.needed for finding in findings)
    summary = {"well": well, "findings": [asdict(finding) for finding in findings]}
    console.show(summary, json, *map(str, findings))
    if not well:
        sys.exit(1)


@contextmanager
def _timing(times: dict[str, float], stage: str) -> Iterator[None]:
    """Note how long a stage took [s]."""
    start = time.perf_counter()
    yield
    times[stage] = round(time.perf_counter() - start, 1)
