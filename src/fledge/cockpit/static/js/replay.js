// A stored flight, as the server tells it, in the words of a live one: at every row a frame, so that the same painters
// paint it.

const ROW_RATE = 20; // [Hz], as `fledge.observation`

export class Replay {
  constructor(told) {
    this.told = told;
    this.rows = told.rows;
    // Stored flights do not say how near their net let anybody come.
    this.flight = { arena: told.arena, obstacles: told.obstacles, lens: told.lens, margins: [] };
    const [uav] = told.columns.vehicles;
    this.trail = Array.from({ length: this.rows }, (_, i) => [uav.x[i], uav.y[i]]);
    const { u, v } = told.columns.picture;
    this.distance = u.map((one, i) => Math.hypot(one - told.lens.width / 2, v[i] - told.lens.height / 2));
  }

  static async fetch(name) {
    return new Replay(await answer(`/api/flights/${name.split("/").map(encodeURIComponent).join("/")}`));
  }

  get seconds() {
    return this.rows / ROW_RATE;
  }

  // The row at a time since the first one [s].
  row(seconds) {
    return Math.max(0, Math.min(this.rows - 1, Math.round(seconds * ROW_RATE)));
  }

  frame(row) {
    const { columns, ideal_radius } = this.told;
    const { picture } = columns;
    return {
      t: columns.t[row],
      vehicles: columns.vehicles.map(({ x, y, z, heading, intervened, reason }) => ({
        x: x[row],
        y: y[row],
        z: z[row],
        heading: heading[row],
        intervened: intervened[row],
        reason: reason[row],
      })),
      picture: {
        u: picture.u[row],
        v: picture.v[row],
        radius: picture.radius[row],
        ideal_radius,
        marks: picture.marks[row],
      },
    };
  }

  // Spans of rows in which a vehicle was not sent what was proposed: {first, last, reason}.
  interventions(vehicle) {
    const { intervened, reason } = this.told.columns.vehicles[vehicle];
    const spans = [];
    intervened.forEach((isHeld, row) => {
      if (!isHeld) return;
      const last = spans.at(-1);
      if (last?.last === row - 1 && last.reason === reason[row]) last.last = row;
      else spans.push({ first: row, last: row, reason: reason[row] });
    });
    return spans;
  }
}

// What the server has to say, or an Error with what is wrong in words.
export async function answer(address) {
  const response = await fetch(address).catch(() => {
    throw new Error("The server does not answer.");
  });
  const said = await response.json().catch(() => ({}));
  if (!response.ok) throw new Error(said.error ?? `The server answers ${response.status}.`);
  return said;
}
