"""The digital twin: vehicles, room, air, cameras and firmware at the other end of the wires."""
