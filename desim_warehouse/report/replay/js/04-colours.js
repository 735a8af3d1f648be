// Colours: safe for colour-blind people (after Okabe and Ito) or the paper's, each on light or dark ground.

const GROUND = {
  light: {
    back: "#eceff2", floor: "#ffffff", border: "#8995a1", aisle: "#aab4be", ink: "#16202a", soft: "#51606e",
    bar: "#b9c3cc", barLine: "#16202a", outline: "#16202a", label: "#ffffff", bay: "#e3efe8", bayLine: "#5c7a69",
    out: "#f4e9dc", outLine: "#8a6a3f",
  },
  dark: {
    back: "#0b0e12", floor: "#1a2027", border: "#5b6874", aisle: "#55616d", ink: "#e8edf2", soft: "#a3b0bd",
    bar: "#4a5560", barLine: "#e8edf2", outline: "#f2f5f8", label: "#ffffff", bay: "#1d2b25", bayLine: "#7fa38f",
    out: "#2f271d", outLine: "#c09b68",
  },
};

const PALETTES = {
  safe: {
    light: { empty: "#0062a3", loaded: "#d55e00", idle: "#00735a", wait: "#f0a500", good: "#d55e00", none: "#2f3942", noneFar: "#aeb8c2",
      low: "#d55e00", full: "#00735a", ring: "#a0418a" },
    dark: { empty: "#56b4e9", loaded: "#ff8a3d", idle: "#2fc79b", wait: "#ffd34d", good: "#f07a2c", none: "#46525e", noneFar: "#333d47",
      low: "#ff8a3d", full: "#2fc79b", ring: "#e58fcb", label: "#0b0e12" },
  },
  paper: {
    light: { empty: "#0000ff", loaded: "#ff0000", idle: "#008000", wait: "#ffb000", good: "#ff0000", none: "#000000", noneFar: "#b0b0b0",
      low: "#ff0000", full: "#008000", ring: "#c000c0" },
    dark: { empty: "#6f8dff", loaded: "#ff4d4d", idle: "#3ddc5a", wait: "#ffd34d", good: "#ff3b3b", none: "#000000", noneFar: "#0c0f12",
      low: "#ff4d4d", full: "#3ddc5a", ring: "#ff7bff", label: "#0b0e12" },
  },
};

// One hue, light to dark and dark to light: more waiting stands out more.
const HEAT = {
  light: ["#f6e8b1", "#f3c969", "#eb9f45", "#d9702f", "#b8432b", "#872139", "#4e0d3f"],
  dark: ["#3b2a4f", "#65316b", "#973a70", "#c84b63", "#ec7150", "#fba749", "#fde58a"],
};

// idle, empty, loading, loaded, queueing, unloading, returning, charging
const COLOUR_OF = ["idle", "empty", "empty", "loaded", "loaded", "loaded", "idle", "idle"];
const WORDS = ["idle", "empty, on its way to a good", "loading", "carrying", "queueing for a server", "unloading", "returning", "charging"];
const QUEUEING = 4;

// A robot that queues without a task does so for a charger.
const moodOf = (state, task) => (state === QUEUEING && task < 0 ? "idle" : COLOUR_OF[state]);
const wordOf = (state, task) => (state === QUEUEING && task < 0 ? "queueing for a charger" : WORDS[state]);

class Colours {
  constructor(palette) {
    this.palette = palette;
    this.theme = null;
    this.system = matchMedia("(prefers-color-scheme: dark)");
  }

  get dark() {
    return this.theme === null ? this.system.matches : this.theme === "dark";
  }

  get now() {
    const ground = this.dark ? "dark" : "light";
    return { ...GROUND[ground], ...PALETTES[this.palette][ground], heat: HEAT[ground] };
  }
}
