// A wind gauge as a tile of Talaia: a bar, the number, and its unit; grey while it is not to be believed.

const FULL = 100;

const style = new CSSStyleSheet();
// A <style> element would be refused by the content security policy; a sheet is not.
style.replaceSync(`
  :host { display: grid; gap: 0.5rem; }
  meter { inline-size: 100%; }
  output { font-size: 1.5rem; font-weight: 700; }
  :host([data-old]) { opacity: 0.7; }
`);

export default class WindGauge extends HTMLElement {
  constructor() {
    super();
    const root = this.attachShadow({ mode: "open" });
    root.adoptedStyleSheets = [style];
    this.meter = document.createElement("meter");
    this.meter.max = FULL;
    this.output = document.createElement("output");
    root.append(this.output, this.meter);
  }

  /** Called whenever a value, its age or its freshness has changed. */
  update({ readings }) {
    const { name, value, unit, freshness } = readings.wind;
    this.toggleAttribute("data-old", freshness !== "live");
    const known = freshness !== "unknown" && !Number.isNaN(value);
    this.meter.value = known ? value : 0;
    this.meter.ariaLabel = name;
    const beside = freshness === "live" ? "" : ` (${freshness})`;
    this.output.textContent = known ? `${value.toFixed(0)} ${unit}${beside}` : "unknown";
  }
}
