"""What was found of safety nets -> figures: safety against performance, and who gets away from a wall again."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from fledge.report.figures import sheet
from fledge.report.figures.looks import INK, MUTED, NETS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Nets = Mapping[str, Any]
"""What results.json holds of them."""


def pareto(nets: Nets) -> "Figure":
    """Contacts with reversed sticks against the cost in ordinary flights, one panel per pilot."""
    pilots = nets["flights"]
    figure, panels = sheet.panels(1, len(pilots), 2.3, left=0.8, apart=(0.12, 0.0), sharex=True, sharey=True)
    for panel, (pilot, flights) in zip(panels, pilots.items(), strict=True):
        for net in flights["combined"]:
            _point(panel, flights, net)
        sheet.logarithmic(panel, "x", (1.0, 1.5, 2.0, 3.0, 5.0))
        panel.set(xlabel="distance RMSE, times that without a net", title=pilot, ylim=(-5.0, 105.0))
    panels[0].set_ylabel("flights with a contact,\nsticks reversed [%]")
    sheet.legend(figure, *panels[0].get_legend_handles_labels()[0])
    return figure


def _point(panel: "Axes", flights: Mapping[str, Any], net: str) -> None:
    reversed_ = flights["reversed"][net]
    contacts = 100.0 * reversed_["contacts"] / reversed_["flights"]
    cost = flights["combined"][net].get("cost")
    error = cost["distance_rmse"] if cost else {"ratio": 1.0, "upper": 1.0}
    colour = NETS[net].light
    panel.hlines(contacts, error["ratio"], error["upper"], color=colour, linewidth=2.2)
    style = {"color": colour, "marker": NETS[net].marker, "markersize": 7.0, "linestyle": "none"}
    panel.plot(error["ratio"], contacts, label=net, **style)


def stand_off(nets: Nets) -> "Figure":
    """The gap between a UAV and the wall it was flown at, over time."""
    figure, (panel,) = sheet.panels(1, 1, 1.9, above=0.1)
    found = nets["stand_off"]
    for net, gap in found["gap_m"].items():
        how = NETS[net]
        panel.plot(found["t_s"], gap, color=how.light, linestyle=how.line, label=net)
    panel.axhline(0.0, color=INK, linewidth=1.6)
    panel.axvline(found["called_back_s"], color=MUTED, linewidth=0.9)
    panel.text(found["called_back_s"], 0.97, " called back", transform=panel.get_xaxis_transform(), va="top")
    panel.set(xlim=(0.0, found["t_s"][-1]), xlabel="time [s]", ylabel="hull to wall [m]")
    sheet.legend(figure, *panel.get_legend_handles_labels()[0])
    return figure
