// A tile of an administrator as the gallery has one: a number, and how far it is to be believed.
export default class GalleryTile extends HTMLElement {
  /** Called whenever a value, its age or its freshness has changed. */
  update({ readings }) {
    const { value, unit, freshness } = readings.speed ?? { value: Number.NaN, unit: "", freshness: "unknown" };
    this.textContent = Number.isNaN(value) ? "unknown" : `${value.toFixed(2)} ${unit}, ${freshness}`;
  }
}
