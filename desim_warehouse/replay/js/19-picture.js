// The page as a picture for slides: title and time, the floors as they are on the screen but twice as fine, what the
// signs mean, and the values of the tiles.

const FINE = 2; // pixels of the picture in one on the screen
const EDGE = 14; // around and between its parts

class Picture {
  constructor(app) {
    this.app = app;
  }

  // The picture as a canvas.
  draw() {
    const { sides, player, tiles } = this.app, colours = this.app.colours.now;
    const wide = sides.reduce((sum, side) => sum + side.view.width, 0) + EDGE * (sides.length + 1);
    const high = Math.max(...sides.map((side) => side.view.height));
    const measure = document.createElement("canvas").getContext("2d");
    const signs = this.rows(measure, signsOf(sides).map(([sign, words]) => ({ sign, words })), wide, 13);
    const values = this.rows(measure, tiles.cells.map((cell) => ({ words: this.value(cell) })), wide, 14);
    const sheet = document.createElement("canvas"), top = sides.length > 1 ? 74 : 50;
    sheet.width = Math.round(wide * FINE);
    sheet.height = Math.round((top + high + 24 * (signs.length + values.length) + 3 * EDGE) * FINE);
    const ctx = sheet.getContext("2d");
    ctx.scale(FINE, FINE);
    ctx.fillStyle = colours.floor;
    ctx.fillRect(0, 0, wide, sheet.height);
    ctx.fillStyle = colours.ink;
    ctx.textBaseline = "middle";
    ctx.font = "600 20px system-ui, sans-serif";
    ctx.fillText(sides[0].header.name, EDGE, 26);
    const after = EDGE + ctx.measureText(sides[0].header.name).width + 10;
    ctx.font = "14px system-ui, sans-serif";
    if (sides.length === 1) ctx.fillText(sides[0].header.label, after, 27);
    ctx.textAlign = "right";
    ctx.font = "600 16px system-ui, sans-serif";
    ctx.fillText(sides[0].clock(player.in(sides[0])), wide - EDGE, 26);
    this.floors(ctx, sides, top, colours);
    const below = this.write(ctx, signs, top + high + EDGE, 13, colours);
    this.write(ctx, values, below + EDGE / 2, 14, colours);
    return sheet;
  }

  floors(ctx, sides, top, colours) {
    let left = EDGE;
    for (const side of sides) {
      const { scene, view } = side;
      ctx.textAlign = "left";
      ctx.fillStyle = colours.ink;
      ctx.font = "14px system-ui, sans-serif";
      if (sides.length > 1) ctx.fillText(side.caption, left, top - 18, view.width);
      scene.resize(FINE);
      scene.draw(this.app.player.in(side));
      ctx.drawImage(scene.canvas, left, top, view.width, view.height);
      ctx.strokeStyle = colours.border;
      ctx.strokeRect(left, top, view.width, view.height);
      scene.resize();
      left += view.width + EDGE;
    }
    this.app.show();
  }

  value(cell) {
    const [title, value] = [cell.head.textContent, cell.runs.map((run) => run?.value.textContent ?? "–")];
    return `${title}: ${value.join(" | ")}`;
  }

  // Words in rows that fit.
  rows(ctx, items, wide, size) {
    ctx.font = `${size}px system-ui, sans-serif`;
    const rows = [[]];
    let x = EDGE;
    for (const item of items) {
      const long = ctx.measureText(item.words).width + (item.sign ? 24 : 0) + 22;
      if (x + long > wide && rows.at(-1).length) {
        rows.push([]);
        x = EDGE;
      }
      rows.at(-1).push({ ...item, x });
      x += long;
    }
    return rows;
  }

  write(ctx, rows, top, size, colours) {
    ctx.font = `${size}px system-ui, sans-serif`;
    ctx.textAlign = "left";
    rows.forEach((row, n) => {
      for (const { sign, words, x } of row) {
        const y = top + 24 * n;
        if (sign) {
          ctx.save();
          ctx.translate(x, y);
          drawSign(ctx, sign, colours);
          ctx.restore();
        }
        ctx.fillStyle = colours.ink;
        ctx.fillText(words, x + (sign ? 24 : 0), y + 9);
      }
    });
    return top + 24 * rows.length;
  }

  // Save it as a file; its name says of what and when.
  save() {
    const { sides, player } = this.app;
    const name = sides[0].header.name.replace(/[^\p{L}\p{N}]+/gu, "-").replace(/^-|-$/g, "").slice(0, 60) || "warehouse";
    this.draw().toBlob((blob) => {
      const link = document.createElement("a"), address = URL.createObjectURL(blob);
      link.href = address;
      link.download = `${name}-${Math.round(player.time)}.png`;
      link.click();
      setTimeout(() => URL.revokeObjectURL(address), 10000);
    }, "image/png");
  }
}
