/**
 * A night along one line: twilights, the Moon, what was observed and what is planned. Arrow keys
 * lead from block to block; the one that is chosen stands below in words.
 */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, query, queryAll } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { formatDuration } from "../../format/duration.js";
import { formatClock, zoneName } from "../../format/time.js";
import { placeBlocks, placeMoment, placePauses, stepBlock, type BlockPause, type BlockState, type PlacedBlock, type NightBlock, type ProposalMark } from "../../series/plan-layout.js";
import { DARKNESS } from "../../sky/night-visibility.js";
import type { NightSky, SkySpan } from "../../sky/night-sky.js";
import { base, plainList, quietText } from "../base/base-style.js";
import { styled } from "../base/style-directive.js";

const HOUR_MS = 3_600_000;
const EMPTY: SkySpan = { from: 0, to: 1 };

/** Each state has a sign of its own, so that it reads without colour. */
const SIGNS: Readonly<Record<BlockState, string>> = { planned: "", current: "▶", done: "✓", suspended: "‖", failed: "✕" };
export const BLOCK_WORDS: Readonly<Record<BlockState, string>> = {
  planned: msg("planned", { id: "planned.block" }),
  current: msg("observed now"),
  done: msg("done"),
  suspended: msg("interrupted, goes on later"),
  failed: msg("failed"),
};
const PAUSE_WORDS: Readonly<Record<BlockPause["kind"], string>> = { flip: msg("meridian flip"), focus: msg("focus run") };

/** A pause as a sentence without its end: “focus run 21:30 (2 min): another filter”. */
export function pauseText({ kind, startMs, endMs, reason }: BlockPause, zone: string): string {
  const lasts = formatDuration((endMs - startMs) / 1000);
  return `${PAUSE_WORDS[kind]} ${formatClock(startMs * 1000, zone).slice(0, 5)} (${lasts})${reason === "" ? "" : `: ${reason}`}`;
}

/** @fires t-block detail is the id of the block that was chosen */
@customElement("t-plan-timeline")
export class PlanTimeline extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-2);
      }
      .scroll {
        overflow-x: auto;
        padding-block-end: var(--t-space-1);
      }
      .line {
        position: relative;
        inline-size: max(100%, calc(var(--hours) * 4.25rem));
        block-size: 10.5rem;
        overflow: hidden;
      }
      .band,
      .moon,
      .hour,
      .now,
      li {
        position: absolute;
        inset-inline-start: calc(var(--left) * 100%);
        inline-size: calc(var(--width, 0) * 100%);
      }
      .band {
        inset-block: 0 2.5rem;
      }
      .day {
        background: var(--t-hour-day);
      }
      .civil {
        background: var(--t-hour-civil);
      }
      .nautical {
        background: var(--t-hour-nautical);
      }
      .astronomical {
        background: var(--t-hour-astronomical);
      }
      .night {
        background: var(--t-hour-night);
      }
      .moon {
        inset-block-start: 0.35rem;
        block-size: 0.5rem;
        border: 1px solid var(--t-edge);
        border-radius: 0.25rem;
        background: var(--t-moon);
      }
      .hour {
        inset-block: 0 0;
        border-inline-start: 1px solid color-mix(in srgb, var(--t-edge) 40%, transparent);
      }
      .hour span {
        position: absolute;
        inset-inline-start: 0.2rem;
        inset-block-end: 1.25rem;
        font-size: var(--t-size-s);
        font-variant-numeric: tabular-nums;
        white-space: nowrap;
      }
      .hour .utc {
        inset-block-end: 0;
        color: var(--t-muted);
      }
      .now {
        inset-block: 0 2.5rem;
        border-inline-start: 2px solid var(--t-bad);
        pointer-events: none;
      }
      .pause {
        position: absolute;
        inset-block-end: 2.5rem;
        inset-inline-start: calc(var(--left) * 100%);
        inline-size: max(6px, calc(var(--width) * 100%));
        block-size: 0.7rem;
        border: 1px solid var(--t-text);
        background: var(--t-surface);
        pointer-events: none;
      }
      .flip {
        background: repeating-linear-gradient(45deg, var(--t-text) 0 2px, var(--t-surface) 2px 4px);
      }
      ol {
        ${plainList}
      }
      li {
        inset-block: 1.4rem 3.2rem;
        min-inline-size: 0.6rem;
        padding-inline-end: 1px;
      }
      button {
        position: relative;
        display: grid;
        align-content: start;
        justify-items: start;
        inline-size: 100%;
        block-size: 100%;
        padding: 0.45rem 0.2rem 0;
        overflow: hidden;
        border: 1px dashed var(--t-edge);
        border-block-start: 0.4rem solid var(--colour);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        font-size: var(--t-size-s);
        line-height: 1.25;
        text-align: start;
        white-space: nowrap;
        cursor: pointer;
      }
      .done button,
      .failed button,
      .suspended button {
        border-style: solid;
        border-color: var(--colour);
        background: var(--t-raised);
      }
      .current button {
        border: 2px solid var(--t-accent);
        border-block-start: 0.4rem solid var(--colour);
      }
      button[aria-pressed="true"] {
        box-shadow: inset 0 0 0 2px var(--t-accent);
      }
      button:focus-visible {
        outline-offset: -3px;
      }
      .letter {
        font-weight: var(--t-weight-strong);
      }
      .key {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-1) var(--t-space-4);
        ${plainList}
        ${quietText}
      }
      .key > span {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
      }
      .key i {
        inline-size: 1.4em;
        block-size: 0.8em;
        border: 1px solid var(--t-edge);
        background: var(--colour);
      }
      .key .focus {
        background: var(--t-surface);
      }
      .key .flip {
        background: repeating-linear-gradient(45deg, var(--t-text) 0 2px, var(--t-surface) 2px 4px);
      }
      .chosen {
        min-block-size: 1.45em;
      }
    `,
  ];

  @property({ attribute: false }) span: SkySpan = EMPTY;
  /** Null where the site's place is not known. */
  @property({ attribute: false }) sky: NightSky | null = null;
  @property({ attribute: false }) blocks: readonly NightBlock[] = [];
  @property({ attribute: false }) marks: ReadonlyMap<string, ProposalMark> = new Map();
  /** The block that stands in words below; empty for none. */
  @property() chosen = "";
  /** The moment (ms since 1970). */
  @property({ type: Number }) ms = 0;
  @property() zone = "UTC";
  @query(".scroll") private readonly scroller!: HTMLElement;
  @queryAll("li button") private readonly buttons!: NodeListOf<HTMLButtonElement>;
  private scrolledFor = 0;

  override updated(changed: PropertyValues<this>): void {
    if (!changed.has("span") || this.span.from === this.scrolledFor) return;
    this.scrolledFor = this.span.from;
    // On a phone the line is wider than the page: what happens now is what one came for.
    const now = placeMoment(this.ms, this.span) ?? 0;
    this.scroller.scrollLeft = now * this.scroller.scrollWidth - this.scroller.clientWidth / 3;
  }

  override render(): TemplateResult {
    const { span } = this;
    const placed = placeBlocks(this.blocks, span);
    const chosen = this.blocks.find(({ id }) => id === this.chosen);
    const now = placeMoment(this.ms, span);
    const hours = Math.max(1, (span.to - span.from) / HOUR_MS);
    // Who has no finger scrolls a night that is wider than the window by its keys.
    return html`<div class="scroll" tabindex="0" role="group" aria-label=${msg("Hours of the night")}>
        <div class="line" ${styled({ "--hours": String(hours) })}>
          <div aria-hidden="true">
            ${map(this.sky?.bands ?? [], ({ id, from, to }) => html`<div class="band ${id}" ${this.placeSpan(from, to)}></div>`)}
            ${map(this.sky?.moonUp ?? [], ({ from, to }) => html`<div class="moon" ${this.placeSpan(from, to)}></div>`)} ${this.renderHours()}
          </div>
          <ol aria-label=${msg("Blocks of the night")} @keydown=${this.onKey}>
            ${repeat(placed, ({ id }) => id, (block, i) => this.renderBlock(block, block.id === chosen?.id || (chosen === undefined && i === 0)))}
          </ol>
          ${map(placePauses(this.blocks, span), ({ kind, left, width }) => html`<div class="pause ${kind}" aria-hidden="true" ${styled({ "--left": String(left), "--width": String(width) })}></div>`)}
          ${now === null ? nothing : html`<div class="now" aria-hidden="true" ${styled({ "--left": String(now) })}></div>`}
        </div>
      </div>
      <p class="chosen" role="status">${chosen === undefined ? html`<span class="muted">${msg("Choose a block to read why it stands there.")}</span>` : this.blockText(chosen)}</p>
      ${this.renderKey()}`;
  }

  private renderBlock(block: PlacedBlock, reached: boolean): TemplateResult {
    const mark = this.marks.get(block.proposal);
    const style = { "--left": String(block.left), "--width": String(block.width), "--colour": `var(--t-series-${String(mark?.colour ?? 1)})` };
    const onPress = (): void => {
      this.choose(block.id);
    };
    return html`<li class=${block.state} ${styled(style)}>
      <button
        type="button"
        id=${`b-${block.id}`}
        tabindex=${reached ? "0" : "-1"}
        aria-pressed=${block.id === this.chosen}
        aria-current=${block.state === "current" ? "time" : nothing}
        title=${this.blockText(block)}
        @click=${onPress}
      >
        <span class="letter" aria-hidden="true">${mark?.letter ?? ""} ${SIGNS[block.state]}</span><span aria-hidden="true">${block.name}</span>
        <span class="visually-hidden">${this.blockText(block)}</span>
      </button>
    </li>`;
  }

  private renderHours(): unknown {
    const { from, to } = this.span;
    const first = Math.ceil(from / HOUR_MS);
    const hours = Array.from({ length: Math.min(48, Math.floor(to / HOUR_MS) - first + 1) }, (_, i) => (first + i) * HOUR_MS);
    const local = zoneName(from * 1000, this.zone);
    // Whose hours they are stands in the key: beside them a long name covers the next one.
    return map(
      hours,
      (ms) => html`<div class="hour" ${this.placeSpan(ms, ms)}>
        <span>${this.clockText(ms)}</span>
        ${local === "UTC" ? nothing : html`<span class="utc">${formatClock(ms * 1000, "UTC").slice(0, 5)}</span>`}
      </div>`,
    );
  }

  private renderKey(): TemplateResult {
    const sky = this.sky;
    const present = new Set(sky?.bands.map(({ id }) => id));
    const local = zoneName(this.span.from * 1000, this.zone);
    const kinds = [...new Set(this.blocks.flatMap(({ pauses }) => (pauses ?? []).map(({ kind }) => kind)))].sort();
    return html`<div class="key" aria-hidden="true">
      ${map(this.marks, ([proposal, { letter, colour }]) => html`<span><i ${styled({ "--colour": `var(--t-series-${String(colour)})` })}></i>${letter} ${proposal}</span>`)}
      ${map(DARKNESS.filter(({ id }) => present.has(id)), ({ id, name }) => html`<span><i ${styled({ "--colour": `var(--t-hour-${id})` })}></i>${name}</span>`)}
      ${sky === null || sky.moonUp.length === 0 ? nothing : html`<span><i ${styled({ "--colour": "var(--t-moon)" })}></i>${msg(str`Moon up, ${(sky.moonLit * 100).toFixed(0)} % lit`)}</span>`}
      ${map(kinds, (kind) => html`<span><i class=${kind}></i>${PAUSE_WORDS[kind]}</span>`)}
      <span><i ${styled({ "--colour": "var(--t-bad)", "inline-size": "3px", border: "0" })}></i>${msg("now")}</span>
      <span>${local === "UTC" ? msg("hours in UTC") : msg(str`hours in ${local}, below them in UTC`)}</span>
    </div>`;
  }

  /** The block in words, as it is heard and as it stands below. */
  private blockText({ name, proposal, startMs, endMs, state, reason, pauses }: NightBlock): string {
    const from = msg(str`${this.clockText(startMs)} to ${this.clockText(endMs)} ${zoneName(startMs * 1000, this.zone)}`);
    const utc = this.zone === "UTC" ? "" : ` (${formatClock(startMs * 1000, "UTC").slice(0, 5)} UTC)`;
    const mark = this.marks.get(proposal);
    const who = proposal === "" ? "" : msg(str`, proposal ${mark === undefined ? "" : `${mark.letter} `}${proposal}`);
    const inner = (pauses ?? []).map((pause) => msg(str`. With a ${pauseText(pause, this.zone)}`)).join("");
    return `${name}${who}: ${from}${utc}, ${formatDuration((endMs - startMs) / 1000)}, ${BLOCK_WORDS[state]}${reason === "" ? "" : `. ${reason}`}${inner}`;
  }

  private clockText(ms: number): string {
    return formatClock(ms * 1000, this.zone).slice(0, 5);
  }

  private placeSpan(from: number, to: number): unknown {
    const span = Math.max(1, this.span.to - this.span.from);
    return styled({ "--left": String((from - this.span.from) / span), "--width": String((to - from) / span) });
  }

  private readonly onKey = (event: KeyboardEvent): void => {
    const placed = placeBlocks(this.blocks, this.span);
    const here = event.target instanceof HTMLElement ? event.target.id.slice(2) : "";
    const next = stepBlock(placed, here, event.key);
    if (next === undefined) return;
    event.preventDefault();
    this.choose(next.id);
    void this.updateComplete.then(() => {
      [...this.buttons].find(({ id }) => id === `b-${next.id}`)?.focus();
    });
  };

  private choose(id: string): void {
    this.chosen = id;
    this.dispatchEvent(new CustomEvent("t-block", { detail: id }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-plan-timeline": PlanTimeline;
  }
  interface GlobalEventHandlersEventMap {
    "t-block": CustomEvent<string>;
  }
}
