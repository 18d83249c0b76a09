"""Fly one flight, score it, store it as MCAP and draw it."""

from pathlib import Path

import fledge
from fledge.learning.demonstrations import Order, collect
from fledge.manoeuvres import Combined
from fledge.pilots import HumanModel
from fledge.report.replay import draw_flight
from fledge.study.evaluation import score


def main(folder=Path(), seconds=20):
    order = Order(Combined(), episodes=1, rows=20 * seconds)
    (flight,) = collect([order], HumanModel(), seed=0)
    scored = score(flight.episode, fledge.Rig())
    print(f"{flight.pilot} on {flight.manoeuvre}, {seconds} s:")
    print(f"  distance of the UGVs' centre from the image's: {scored.distance:.1f} px on average")
    print(f"  squared radius error: {scored.radius:.1f} px² on average")
    print(f"  all UGVs in view: {scored.in_view:.1%} of the time")
    fledge.write_flight(folder / "flight.mcap", flight)
    draw_flight(flight, folder / "flight.png")
    print("flight.mcap opens in Foxglove; flight.png shows it at a glance")
    return fledge.read_flight(folder / "flight.mcap")


if __name__ == "__main__":
    main()
