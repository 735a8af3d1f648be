// Which part of the warehouse is on the canvas: screen = scale * world + offset, in CSS pixels.

const pixelRatio = () => Math.min(window.devicePixelRatio || 1, 2);

// A canvas fitted to its place on the page and emptied: its context in CSS pixels, and how large it is there.
function emptied(canvas) {
  const ratio = pixelRatio(), width = canvas.clientWidth, height = canvas.clientHeight;
  const wide = Math.max(Math.round(width * ratio), 1), high = Math.max(Math.round(height * ratio), 1);
  if (canvas.width !== wide || canvas.height !== high) [canvas.width, canvas.height] = [wide, high];
  const ctx = canvas.getContext("2d");
  ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
  ctx.clearRect(0, 0, width, height);
  return { ctx, width, height };
}

class View {
  constructor(bounds) {
    this.bounds = bounds;
    this.width = this.height = 1;
    this.scale = 1;
    this.x = this.y = 0;
    this.fitted = true;
  }

  resize(width, height) {
    const [cx, cy] = this.world(this.width / 2, this.height / 2);
    [this.width, this.height] = [width, height];
    if (this.fitted) this.fit();
    else this.centre(cx, cy);
  }

  get least() {
    const { left, top, right, bottom } = this.bounds;
    return Math.min((this.width - 16) / (right - left), (this.height - 16) / (bottom - top));
  }

  // See the same part as another view of a floor of the same extent.
  as(other) {
    this.scale = (other.scale * this.least) / other.least;
    this.fitted = other.fitted;
    this.centre(...other.world(other.width / 2, other.height / 2));
  }

  fit() {
    const { left, top, right, bottom } = this.bounds;
    this.scale = Math.max(this.least, 1e-9);
    this.fitted = true;
    this.centre((left + right) / 2, (top + bottom) / 2);
  }

  centre(wx, wy) {
    this.x = this.width / 2 - wx * this.scale;
    this.y = this.height / 2 - wy * this.scale;
  }

  world(sx, sy) {
    return [(sx - this.x) / this.scale, (sy - this.y) / this.scale];
  }

  pan(dx, dy) {
    this.x += dx;
    this.y += dy;
    this.fitted = false;
  }

  zoom(factor, sx = this.width / 2, sy = this.height / 2) {
    const [wx, wy] = this.world(sx, sy);
    this.scale = Math.min(Math.max(this.scale * factor, this.least / 4), this.least * 200);
    this.x = sx - wx * this.scale;
    this.y = sy - wy * this.scale;
    this.fitted = false;
  }

  // So near that something of size `reach` (world) about a point fills half of the view.
  close(wx, wy, reach) {
    this.scale = Math.max(Math.min(this.width, this.height) / (4 * reach), this.least);
    this.fitted = false;
    this.centre(wx, wy);
  }

  // Whether something of size `reach` (world) about a point can be seen.
  shows(wx, wy, reach) {
    const sx = wx * this.scale + this.x, sy = wy * this.scale + this.y, r = reach * this.scale;
    return sx > -r && sy > -r && sx < this.width + r && sy < this.height + r;
  }
}
