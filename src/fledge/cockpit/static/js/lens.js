// The downward camera, as in `fledge.camera`: a pinhole that hangs level. Pixel u goes to the right, v down the
// picture, and the top of the picture is where the UAV's nose points.

const NEAREST = 0.1; // [m]

export class Lens {
  constructor({ focal, width, height }, uav) {
    this.focal = focal;
    this.width = width;
    this.height = height;
    this.uav = uav;
    this.cos = Math.cos(uav.heading);
    this.sin = Math.sin(uav.heading);
  }

  // Pixel of a point of the world [m].
  pixel(x, y, z = 0) {
    const { uav, cos, sin } = this;
    const [east, north] = [x - uav.x, y - uav.y];
    const scale = this.focal / Math.max(uav.z - z, NEAREST);
    return [this.width / 2 - scale * (cos * north - sin * east), this.height / 2 - scale * (cos * east + sin * north)];
  }

  // The point of the floor that a pixel shows.
  floor(u, v) {
    const { uav, cos, sin } = this;
    const scale = Math.max(uav.z, NEAREST) / this.focal;
    const [left, forward] = [(this.width / 2 - u) * scale, (this.height / 2 - v) * scale];
    return [uav.x + cos * forward - sin * left, uav.y + sin * forward + cos * left];
  }

  // The four corners of what is seen of the floor.
  get footprint() {
    return [[0, 0], [this.width, 0], [this.width, this.height], [0, this.height]].map(([u, v]) => this.floor(u, v));
  }
}
