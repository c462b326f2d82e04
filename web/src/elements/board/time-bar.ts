/** The moment that a board shows, and what moves it: play, pause, speed, step, scrub. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { formatClock, knownZone, timeText } from "../../format/time.js";
import { clockOf, DAY_US, HOUR_US, MINUTE_US, momentProblem, SECOND_US } from "../../series/zone-clock.js";
import { base, quietText, raisedBox } from "../base/base-style.js";
import { renderOptions } from "../forms/form-parts.js";
import { control } from "../forms/input-style.js";
import "../base/icon.js";
import "../forms/button.js";

export const BAR_LENGTHS: readonly (readonly [us: number, label: string])[] = [
  [10 * MINUTE_US, msg("10 minutes")], [HOUR_US, msg("1 hour")], [6 * HOUR_US, msg("6 hours")], [DAY_US, msg("1 day")], [7 * DAY_US, msg("7 days")],
];
const LENGTHS: readonly (readonly [string, string])[] = BAR_LENGTHS.map(([us, label]) => [String(us), label]);
const STEP_US = SECOND_US;
const BIG_STEP_US = 10 * SECOND_US;

/** What the bar spans: it ends now while the moment lies in it, else the moment stands in its middle. Pure. */
export function barSpan(us: number, endUs: number, lengthUs: number): { readonly fromUs: number; readonly toUs: number } {
  const toUs = us >= endUs - lengthUs ? endUs : us + lengthUs / 2;
  return { fromUs: toUs - lengthUs, toUs };
}

/**
 * @fires t-seek where the moment is put (µs)
 * @fires t-step by how much it is moved (µs)
 * @fires t-play play, or pause
 * @fires t-speed how many times as fast it plays
 * @fires t-length how much time the bar is to span (µs)
 * @slot marks - what happened, placed by `--at`: its part of the bar, 0 to 1
 * @slot keys - more buttons
 * @slot stretches - what lasted: from `--from`, over `--part` of the bar
 * @fires t-note write a note at the moment, or over the span up to it
 * @fires t-begin a note's span begins at the moment, or is dropped again
 * @fires t-now back to now
 * @fires t-retry ask the hub once more
 */
@customElement("t-time-bar")
export class TimeBar extends LitElement {
  static override styles = [
    base,
    control,
    css`
      :host {
        position: sticky;
        inset-block-start: var(--t-bar-top, 3.75rem);
        z-index: 9;
        display: grid;
        grid-template-columns: minmax(0, 1fr);
        gap: var(--t-space-2);
        padding: var(--t-space-2) var(--t-space-3);
        ${raisedBox}
        border-color: var(--t-accent);
        border-style: dashed;
      }
      .stamp {
        display: flex;
        flex-wrap: wrap;
        align-items: baseline;
        gap: 0 var(--t-space-3);
        min-inline-size: 0;
      }
      .stamp strong {
        color: var(--t-accent);
      }
      time {
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
        font-variant-numeric: tabular-nums;
      }
      .utc,
      .ends {
        ${quietText}
        font-variant-numeric: tabular-nums;
      }
      .keys {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2);
      }
      .keys label {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-1);
        font-size: var(--t-size-s);
      }
      .keys input {
        inline-size: 12.5rem;
      }
      .now {
        margin-inline-start: auto;
      }
      .rail {
        position: relative;
        display: grid;
        min-block-size: var(--t-touch);
        padding-block-start: 1.5rem;
      }
      ::slotted([slot="marks"]) {
        position: absolute;
        inset-block-start: 0;
        /* As the slider's thumb: its middle stays half its width inside. */
        inset-inline-start: calc(8px + (100% - 16px) * var(--at));
        translate: -50% 0;
      }
      ::slotted([slot="stretches"]) {
        position: absolute;
        inset-block-start: 1.4rem;
        inset-inline-start: calc(8px + (100% - 16px) * var(--from));
        inline-size: max(2px, calc((100% - 16px) * var(--part)));
        block-size: 0.35rem;
        border-radius: 0.2rem;
        background: var(--t-muted);
      }
      input[type="range"] {
        inline-size: 100%;
        min-block-size: var(--t-touch);
        margin: 0;
        padding: 0;
        accent-color: var(--t-accent);
      }
      .ends {
        display: flex;
        justify-content: space-between;
        gap: var(--t-space-3);
      }
      .said {
        margin: 0;
        font-size: var(--t-size-s);
      }
      .warn {
        color: var(--t-warn);
        font-weight: var(--t-weight-strong);
      }
      .small {
        display: none;
      }
      /* A phone's bar is two rows, so that the board below it is seen: the rest is behind "More". */
      @media (max-width: 45rem) {
        :host {
          gap: 0;
          padding: var(--t-space-1) var(--t-space-2);
        }
        .small {
          display: revert;
        }
        .large {
          display: none;
        }
        .stamp {
          flex-wrap: nowrap;
          align-items: center;
          gap: var(--t-space-2);
        }
        .when {
          flex: 1;
          min-inline-size: 0;
          line-height: 1.2;
        }
        time {
          font-size: var(--t-size-s);
        }
        .now {
          margin-inline-start: 0;
        }
        .rail {
          padding-block-start: 0.5rem;
        }
        :host(:not([expanded])) :is(.utc, .ends, .keys, .said:not(.warn)) {
          display: none;
        }
        :host([expanded]) .stamp {
          flex-wrap: wrap;
        }
        :host([expanded]) .keys {
          padding-block: var(--t-space-2);
        }
      }
    `,
  ];

  /** The moment (µs since the epoch, UTC). */
  @property({ type: Number }) us = 0;
  /** The newest moment that can be shown (µs). */
  @property({ type: Number }) end = 0;
  @property() zone = "UTC";
  @property({ type: Boolean }) playing = false;
  @property({ type: Number }) speed = 1;
  @property({ attribute: false }) speeds: readonly number[] = [1];
  @property() state: "ready" | "loading" | "failed" | "silent" = "ready";
  /** The moment has come up to the newest. */
  @property({ type: Boolean, attribute: "at-end" }) atEnd = false;

  /** On a phone: all of it is shown, and not only the moment, play and the slider. */
  @property({ type: Boolean, reflect: true }) expanded = false;
  /** Notes may be written. */
  @property({ type: Boolean }) notes = false;
  /** Where a note over a span was begun (µs); null while none was. */
  @property({ attribute: false }) begun: number | null = null;

  /** How much time the bar spans (µs). */
  @property({ type: Number }) length = HOUR_US;

  /** Why what was written is no moment. */
  @state() private mistake = "";

  override render(): TemplateResult {
    const { us, zone, end } = this;
    const span = barSpan(us, end, this.length);
    const text = timeText(us, zone, Date.now() * 1000);
    const from = timeText(span.fromUs, zone, end);
    const to = timeText(span.toUs, zone, end);
    return html`<div class="stamp">
        <t-button class="small" ?disabled=${this.atEnd} @click=${this.onPlay}>${this.playing ? msg("Pause") : msg("Play")}</t-button>
        <span class="when"><strong>${msg("Past")}</strong> <time datetime=${text.machine}>${text.local} ${text.zone}</time></span>
        ${text.zone === "UTC" ? nothing : html`<span class="utc">${text.utc}</span>`}
        <t-button class="now" kind="primary" label=${msg("Back to now")} @click=${this.onNow}><span class="large">${msg("Back to now")}</span><span class="small">${msg("Now")}</span></t-button>
        <t-button class="small" kind="quiet" label=${msg("More of the bar")} pressed=${this.expanded ? "true" : "false"} @click=${this.onExpand}>${msg("More")}</t-button>
      </div>
      <div class="rail"><slot name="stretches"></slot><slot name="marks"></slot>
        <input
          type="range"
          aria-label=${msg("Moment")}
          aria-valuetext=${`${text.local} ${text.zone}`}
          min="0"
          max=${this.length}
          step=${Math.max(SECOND_US / 10, this.length / 36_000)}
          .value=${String(us - span.fromUs)}
          @input=${this.onScrub}
          @keydown=${this.onKey}
        />
      </div>
      <div class="ends"><span>${from.local}</span><span>${span.toUs >= end ? msg("now") : to.local}</span></div>
      <div class="keys" role="group" aria-label=${msg("Play")}>
        <t-button ?disabled=${this.atEnd} @click=${this.onPlay}>${this.playing ? msg("Pause") : msg("Play")}</t-button>
        <t-button kind="quiet" @click=${this.stepper(-STEP_US)}>−1 s</t-button>
        <t-button kind="quiet" ?disabled=${this.atEnd} @click=${this.stepper(STEP_US)}>+1 s</t-button>
        <label>${msg("Speed")} <select aria-label=${msg("Speed")} @change=${this.onSpeed}>${renderOptions(this.speeds.map((speed) => [String(speed), `${String(speed)} ×`] as const), String(this.speed))}</select></label>
        <label>${msg("Bar")} <select aria-label=${msg("Length of the bar")} @change=${this.onLength}>${renderOptions(LENGTHS, String(this.length))}</select></label>
        <label>${msg("Go to")} <input type="text" autocomplete="off" maxlength="30" placeholder="2026-03-29 14:05:09" aria-label=${msg(str`Go to a moment (${zone})`)} aria-invalid=${this.mistake === "" ? "false" : "true"} @change=${this.onWritten} /></label>
        ${this.notes ? this.renderNoteKeys() : nothing} <slot name="keys"></slot>
      </div>
      <div role="status">${this.renderState()}</div>`;
  }

  private renderNoteKeys(): TemplateResult {
    const { begun } = this;
    return html`<t-button kind="quiet" @click=${this.onNote}>${begun === null ? msg("Note") : msg(str`Note since ${formatClock(begun, this.zone)}`)}</t-button>
      <t-button kind="quiet" pressed=${begun === null ? "false" : "true"} @click=${this.onBegin}>${msg("Begin a span")}</t-button>`;
  }

  private renderState(): unknown {
    if (this.mistake !== "") return html`<p class="said warn">${this.mistake}</p>`;
    if (this.state === "failed") return html`<p class="said warn">${msg("The hub did not give what was recorded.")} <t-button kind="quiet" @click=${this.onRetry}>${msg("Try again")}</t-button></p>`;
    if (this.atEnd) return html`<p class="said">${msg("That is the newest that is recorded. “Back to now” shows what comes.")}</p>`;
    if (this.state === "silent") return html`<p class="said warn">${msg("No value was recorded in the minute before this moment.")}</p>`;
    return nothing;
  }

  private fire(type: string, detail?: number): void {
    this.dispatchEvent(new CustomEvent(type, { detail }));
  }

  private stepper(byUs: number): () => void {
    return () => {
      this.fire("t-step", byUs);
    };
  }

  private readonly onNow = (): void => {
    this.fire("t-now");
  };

  private readonly onExpand = (): void => {
    this.expanded = !this.expanded;
  };

  private readonly onNote = (): void => {
    this.fire("t-note");
  };

  private readonly onBegin = (): void => {
    this.fire("t-begin");
  };

  private readonly onPlay = (): void => {
    this.fire("t-play");
  };

  private readonly onRetry = (): void => {
    this.fire("t-retry");
  };

  private readonly onScrub = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const { fromUs, toUs } = barSpan(this.us, this.end, this.length);
    // The right end of a bar that ends now means the newest.
    this.fire("t-seek", Math.min(toUs, fromUs + Number(event.target.value)));
  };

  /** Seconds by the arrows, whatever the bar spans; space plays. */
  private readonly onKey = (event: KeyboardEvent): void => {
    const by = { ArrowLeft: -STEP_US, ArrowRight: STEP_US, PageDown: -BIG_STEP_US, PageUp: BIG_STEP_US }[event.key];
    if (by !== undefined) this.fire("t-step", by);
    else if (event.key === " ") this.fire("t-play");
    else return;
    event.preventDefault();
  };

  /** By the site's clock, however far back. */
  private readonly onWritten = (event: Event): void => {
    if (!(event.target instanceof HTMLInputElement)) return;
    const us = clockOf(knownZone(this.zone)).fromInput(event.target.value);
    this.mistake = momentProblem(event.target.value, us);
    if (Number.isNaN(us)) return;
    event.target.value = "";
    this.fire("t-seek", Math.min(this.end, us));
  };

  private readonly onSpeed = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.fire("t-speed", Number(event.target.value));
  };

  private readonly onLength = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.fire("t-length", Number(event.target.value));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-time-bar": TimeBar;
  }
}
