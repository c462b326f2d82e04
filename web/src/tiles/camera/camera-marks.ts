/** What one camera's tile knows of its zones and lines: whether they are shown, and what counts at them. */

import { html, nothing, type LitElement } from "lit";
import { LiveValuesController } from "../../controllers/live-values.js";
import { laneMark } from "../../elements/camera/lane-shape.js";
import { markCount, type PictureMark } from "../../elements/camera/mark-shapes.js";
import "./marks-button.js";
import type { DetectShape, LaneShape, PictureMarkShape, PictureModelShape } from "../../generated/api.js";

const NONE: readonly PictureMark[] = [];
/** One choice for all cameras of this browser; kept only where they are hidden. */
const HIDDEN_KEY = "talaia.marks.hidden";

export class CameraMarks {
  private detects: DetectShape | null = null;
  private lane: LaneShape | null = null;
  private models: readonly PictureModelShape[] = [];
  private hidden: boolean;
  private readonly values: LiveValuesController;

  constructor(
    private readonly host: LitElement,
    private readonly notes: Pick<Storage, "getItem" | "setItem" | "removeItem"> | null,
  ) {
    this.values = new LiveValuesController(host);
    this.hidden = this.readHidden();
  }

  /** Call it from `willUpdate`. */
  setSubject(site: string, detects: DetectShape | null, lane: LaneShape | null = null, models: readonly PictureModelShape[] = []): void {
    [this.detects, this.lane, this.models] = [detects, lane, models];
    const counts = this.described.flatMap((mark) => mark.counts.map(({ signal }) => signal));
    const wanted = lane === null ? counts : [...counts, lane.offset, lane.heading, lane.width];
    this.values.observeChannels(site, this.hidden ? [] : [...new Set(wanted)].filter((signal) => signal !== ""));
  }

  /** What lies over the picture now. */
  get marks(): readonly PictureMark[] {
    if (this.hidden) return NONE;
    const zones = [...(this.detects?.zones ?? []), ...this.modelZones].map((mark) => this.markNow("zone", mark));
    const lines = (this.detects?.lines ?? []).map((mark) => this.markNow("line", mark));
    const lane = this.laneNow();
    const marks = [...zones, ...lines, ...(lane === null ? [] : [lane])];
    return marks.length === 0 ? NONE : marks;
  }

  /** The button that shows and hides them; nothing where there are none. */
  renderButton(): unknown {
    if (this.described.length === 0 && this.lane === null) return nothing;
    return html`<t-marks-button slot="tool" ?on=${!this.hidden} @click=${this.onSwitch}></t-marks-button>`;
  }

  private get described(): readonly PictureMarkShape[] {
    return [...(this.detects?.zones ?? []), ...(this.detects?.lines ?? []), ...this.modelZones];
  }

  private get modelZones(): readonly PictureMarkShape[] {
    return this.models.flatMap(({ zones }) => zones);
  }

  private markNow(kind: PictureMark["kind"], { id, name, points, counts }: PictureMarkShape): PictureMark {
    const said = counts.map(({ signal, label, measure, max_age }) => {
      // An old count over a live picture would be believed.
      const live = this.values.freshnessOf(signal, max_age) === "live";
      const value = live ? (this.values.readingOf(signal)?.value ?? Number.NaN) : Number.NaN;
      return markCount(measure, label, Number.isFinite(value) ? value : null);
    });
    return { kind, id, name, points: points.map(({ x, y }) => [x, y] as const), counts: said };
  }

  /** A lane of some seconds ago over a live picture would be believed, too. */
  private laneNow(): PictureMark | null {
    const { lane } = this;
    if (lane === null || lane.width === "" || lane.heading === "") return null;
    const [offset, heading, width] = [lane.offset, lane.heading, lane.width].map((signal) =>
      this.values.freshnessOf(signal, lane.max_age) === "live" ? (this.values.readingOf(signal)?.value ?? Number.NaN) : Number.NaN,
    );
    if (offset === undefined || heading === undefined || width === undefined || !Number.isFinite(offset + heading + width)) return null;
    return laneMark(lane.to_picture, [lane.near, lane.far], { offset, heading, width });
  }

  private readHidden(): boolean {
    try {
      return this.notes?.getItem(HIDDEN_KEY) === "1";
    } catch {
      return false;
    }
  }

  private readonly onSwitch = (): void => {
    this.hidden = !this.hidden;
    try {
      if (this.hidden) this.notes?.setItem(HIDDEN_KEY, "1");
      else this.notes?.removeItem(HIDDEN_KEY);
    } catch {
      // Full, or forbidden: it holds for this page.
    }
    this.host.requestUpdate();
  };
}
