// Colours, as the page is given them: safe for colour-blind people or the paper's, each on light or dark ground.

class Colours {
  constructor(palette, { ground, palettes, heat, steps }) {
    this.palette = palette;
    this.ground = ground;
    this.palettes = palettes;
    this.heat = heat;
    this.steps = steps;
    this.theme = null;
    this.system = matchMedia("(prefers-color-scheme: dark)");
  }

  get dark() {
    return this.theme === null ? this.system.matches : this.theme === "dark";
  }

  get now() {
    const ground = this.dark ? "dark" : "light";
    return { ...this.ground[ground], ...this.palettes[this.palette][ground], heat: this.heat[ground] };
  }
}
