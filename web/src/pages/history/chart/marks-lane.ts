/** What happened in the window: a lane of marks above the charts, each with what it says. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, queryAll, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../../../elements/base/base-style.js";
import type { ChartIndent } from "../../../elements/chart/chart-model.js";
import { momentText } from "../../../elements/chart/cursor-values.js";
import { styled } from "../../../elements/base/style-directive.js";
import { knownZone } from "../../../format/time.js";
import { lengthOf, type TimeSpan } from "../../../series/time-window.js";
import { renderMarkShape } from "./mark-shapes.js";
import { clusterMarks, KINDS, type MarkCluster, type EventMark, type MarkKind } from "./event-marks.js";
import { marksLaneStyle } from "./marks-lane-style.js";

/** Marks nearer than this are put together (CSS pixels). */
const APART = 22;
/** The tooltip tells so many; the table of events tells all. */
const TOLD = 12;

/**
 * Marks are one stop of the Tab key; the arrow keys go from one to the next.
 *
 * @fires t-cursor detail is the moment of the mark that is looked at (µs), or null
 * @fires t-hide detail is the kinds that are to be hidden
 */
@customElement("t-marks-lane")
export class MarksLane extends LitElement {
  static override styles = [base, marksLaneStyle];

  @property({ attribute: false }) marks: readonly EventMark[] = [];
  @property({ attribute: false }) without: readonly MarkKind[] = [];
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  /** Room beside the plots, so that the lane lines up with them. */
  @property({ attribute: false }) indent: ChartIndent = { left: 0, right: 0 };
  /** Older events of the window were left out. */
  @property({ type: Boolean }) more = false;
  /** What could not be loaded; empty for nothing. */
  @property() problem = "";
  @property() zone = "UTC";

  @queryAll(".place button") private readonly buttons!: NodeListOf<HTMLButtonElement>;

  /** The mark that is looked at, by its time; null for none. */
  @state() private open: number | null = null;
  /** The mark that Tab comes to. */
  @state() private stop = 0;
  /** CSS pixels of the lane. */
  @state() private width = 600;

  private readonly sized = new ResizeObserver(([entry]) => {
    this.width = Math.round(entry?.contentRect.width ?? this.width);
  });

  override connectedCallback(): void {
    super.connectedCallback();
    this.sized.observe(this);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.sized.disconnect();
  }

  override render(): TemplateResult {
    const shown = this.clusters();
    const at = shown.findIndex(({ timeUs }) => timeUs === this.open);
    return html`
      <div class="head" @change=${this.onFilterChange}>
        <strong>${msg("Events")}</strong> ${map(KINDS, (kind) => this.renderFilter(kind))}
        ${shown.length === 0 && this.problem === "" ? html`<span class="muted">${msg("none to show in this window")}</span>` : nothing}
        ${this.problem === "" ? nothing : html`<span role="alert">${this.problem}</span>`}
        ${this.more ? html`<span class="muted">${msg("Only the newest 1000 are shown: zoom in for more.")}</span>` : nothing}
      </div>
      <div
        class="track"
        ${styled({ "--left": `${String(this.indent.left)}px`, "--right": `${String(this.indent.right)}px` })}
        @keydown=${this.onKeyDown}
        @pointerleave=${this.closeTip}
        @focusout=${this.closeTip}
      >
        <div class="place" role="toolbar" aria-label=${msg("Events in the window")}>
          ${repeat(
            shown,
            ({ timeUs }) => timeUs,
            (cluster, i) => this.renderButton(cluster, i, shown.length),
          )}
        </div>
        ${at < 0 ? nothing : this.renderTip(shown[at])}
      </div>
    `;
  }

  private renderFilter({ kind, name }: { kind: MarkKind; name: string }): unknown {
    const count = this.marks.filter((mark) => mark.kind === kind && this.isInWindow(mark)).length;
    const hidden = this.without.includes(kind);
    if (count === 0 && !hidden) return nothing;
    return html`<label
      ><input type="checkbox" .value=${kind} .checked=${!hidden} /><svg viewBox="0 0 16 16" class=${kind}>${renderMarkShape(kind)}</svg>
      ${name} <span class="muted">${count}</span></label
    >`;
  }

  private renderButton({ timeUs, marks, kind, good }: MarkCluster, index: number, count: number): TemplateResult {
    const first = marks[0];
    const name = marks.length > 1 ? msg(str`${String(marks.length)} events, first ${first?.title ?? ""}`) : (first?.title ?? "");
    const part = (timeUs - this.span.fromUs) / lengthOf(this.span);
    const tab = index === Math.min(this.stop, count - 1) ? 0 : -1;
    return html`<button
      type="button"
      tabindex=${tab}
      ${styled({ "inset-inline-start": `${String(100 * part)}%` })}
      aria-label=${`${this.moment(timeUs)}, ${name}`}
      aria-expanded=${timeUs === this.open ? "true" : "false"}
      aria-describedby=${timeUs === this.open ? "tip" : nothing}
      data-at=${timeUs}
      @pointerenter=${this.openTip}
      @focus=${this.openTip}
      @click=${this.openTip}
    >
      <svg viewBox="0 0 16 16" class=${good ? kind : "bad"}>${renderMarkShape(kind)}</svg>
      ${marks.length > 1 ? html`<span class="many">${marks.length}</span>` : nothing}
    </button>`;
  }

  private renderTip(cluster: MarkCluster | undefined): unknown {
    if (cluster === undefined) return nothing;
    const part = (cluster.timeUs - this.span.fromUs) / lengthOf(this.span);
    // Over its mark as far as the lane goes: at the left its left side, at the right its right side.
    const style = { left: `calc(var(--left) + ${String(part)} * (100% - var(--left) - var(--right)))`, translate: `${String(-100 * part)}% 0` };
    const rest = cluster.marks.length - TOLD;
    return html`<div id="tip" class="tip" role="tooltip" ${styled(style)}>
      ${map(cluster.marks.slice(0, TOLD), (mark) => this.renderDetails(mark))}
      ${rest > 0 ? html`<span class="muted">${msg(str`and ${rest} more: zoom in to tell them apart`)}</span>` : nothing}
    </div>`;
  }

  private renderDetails({ timeUs, kind, title, device, who, message, good }: EventMark): TemplateResult {
    const about = [device, who === "" ? "" : msg(str`by ${who}`)].filter(Boolean).join(", ");
    return html`<p>
      <svg viewBox="0 0 16 16" class=${good ? kind : "bad"}>${renderMarkShape(kind)}</svg>
      <span><time>${this.moment(timeUs)}</time> <strong>${title}</strong></span>
      ${about === "" ? nothing : html`<span class="muted">${about}</span>`} ${message === "" ? nothing : html`<span>${message}</span>`}
    </p>`;
  }

  private moment(us: number): string {
    return momentText(us, knownZone(this.zone), lengthOf(this.span));
  }

  private isInWindow({ timeUs }: EventMark): boolean {
    return timeUs >= this.span.fromUs && timeUs <= this.span.toUs;
  }

  private clusters(): MarkCluster[] {
    const shown = this.marks.filter(({ kind }) => !this.without.includes(kind));
    return clusterMarks(shown, this.span, APART / Math.max(1, this.width - this.indent.left - this.indent.right));
  }

  private readonly openTip = (event: Event): void => {
    if (!(event.currentTarget instanceof HTMLElement)) return;
    const at = Number(event.currentTarget.dataset["at"]);
    this.open = at;
    this.stop = Math.max(0, this.clusters().findIndex(({ timeUs }) => timeUs === at));
    this.fireEvent("t-cursor", at);
  };

  private readonly closeTip = (): void => {
    if (this.open === null) return;
    this.open = null;
    this.fireEvent("t-cursor", null);
  };

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    const { buttons } = this;
    const last = buttons.length - 1;
    const to = { ArrowRight: Math.min(last, this.stop + 1), ArrowLeft: Math.max(0, this.stop - 1), Home: 0, End: last }[event.key];
    if (event.key === "Escape" && this.open !== null) this.closeTip();
    else if (to !== undefined && !event.ctrlKey && !event.altKey && !event.metaKey) buttons[to]?.focus();
    else return;
    // The page moves its window with the same keys.
    event.preventDefault();
    event.stopPropagation();
  };

  private readonly onFilterChange = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const { value, checked } = event.target;
    this.fireEvent("t-hide", KINDS.map(({ kind }) => kind).filter((kind) => (kind === value ? !checked : this.without.includes(kind))));
  };

  private fireEvent(kind: string, detail: unknown): void {
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-marks-lane": MarksLane;
  }
  interface HTMLElementEventMap {
    "t-hide": CustomEvent<readonly MarkKind[]>;
  }
}
