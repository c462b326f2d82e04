/** Whether the weather lets the roof open, in large words, with the rule that decides and its numbers. */

import { msg, str } from "@lit/localize";
import { css, html, nothing, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { renderTable, tables, type TableColumn } from "../../elements/layout/data-table.js";
import { formatDuration } from "../../format/duration.js";
import type { StateMeaning } from "../../generated/api.js";
import { interlocksContext } from "../../state/contexts.js";
import { NO_DEVICE, DevicePart, partStyle } from "./device-part.js";
import { meaningOf, signalWith } from "./roles.js";
import { judgeStation, type LimitLine, type WeatherVerdict, type VerdictWord, VERDICT_WORDS } from "./weather-verdict.js";
import "../../elements/feedback/status.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../signal-value.js";

/** How a station's own word is shown, by what it means. */
const OWN_KINDS: Readonly<Partial<Record<StateMeaning, StatusKind>>> = { safe: "ok", warning: "warn", unsafe: "bad" };
const STANDS: Readonly<Record<LimitLine["stands"], { kind: StatusKind; word: string }>> = {
  fine: { kind: "ok", word: msg("within") },
  beyond: { kind: "bad", word: msg("beyond") },
  returning: { kind: "warn", word: msg("near") },
  unknown: { kind: "unknown", word: msg("unknown") },
};
/** Each verdict has a shape of its own, so that it reads without colour. */
const SHAPES: Readonly<Record<VerdictWord, SVGTemplateResult>> = {
  safe: svg`<circle cx="24" cy="24" r="21"></circle><path class="cut" d="m14 25 7 7 14-15"></path>`,
  warn: svg`<path d="M24 3 46 44H2z"></path><path class="cut" d="M24 17v13M24 35v3"></path>`,
  wait: svg`<circle class="open" cx="24" cy="24" r="20"></circle><path class="open" d="M24 12v13l9 5"></path>`,
  unsafe: svg`<path d="M15 3h18l12 12v18L33 45H15L3 33V15z"></path><path class="cut" d="m16 16 16 16M32 16 16 32"></path>`,
  overridden: svg`<path d="M24 3 46 44H2z"></path><path class="cut" d="M24 17v13M24 35v3"></path>`,
  unknown: svg`<circle class="open dashed" cx="24" cy="24" r="20"></circle><path class="open" d="M18 19a6 6 0 1 1 8 6c-2 1-2 3-2 4M24 34v2"></path>`,
  none: svg`<circle class="open" cx="24" cy="24" r="20"></circle><path class="open" d="M15 24h18"></path>`,
};

const COLUMNS: readonly TableColumn<LimitLine>[] = [
  { title: msg("Value"), heads: true, cell: ({ name }) => html`<strong>${name}</strong>` },
  { title: msg("Now"), cell: ({ now }) => now },
  { title: msg("Unsafe", { id: "unsafe.limit" }), cell: ({ limit }) => limit },
  { title: msg("It is"), cell: ({ stands }) => html`<t-status kind=${STANDS[stands].kind} .word=${STANDS[stands].word}></t-status>` },
  { title: msg("Rule"), name: "muted", cell: ({ rule }) => rule },
];

@customElement("t-part-weather")
export class WeatherPart extends DevicePart {
  static override styles = [
    base,
    partStyle,
    tables,
    css`
      .verdict {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        align-items: center;
        gap: var(--t-space-3) var(--t-space-5);
        border-inline-start: 0.5rem solid var(--tone);
        --tone: var(--t-stale);
      }
      .safe {
        --tone: var(--t-ok);
      }
      .warn,
      .wait,
      .overridden {
        --tone: var(--t-warn);
      }
      .unsafe {
        --tone: var(--t-bad);
      }
      .verdict svg {
        inline-size: 4.5rem;
        block-size: 4.5rem;
        fill: var(--tone);
      }
      .cut {
        fill: none;
        stroke: var(--t-surface);
        stroke-width: 5;
      }
      .open {
        fill: none;
        stroke: var(--tone);
        stroke-width: 4;
      }
      .dashed {
        stroke-dasharray: 8 5;
      }
      .word {
        color: var(--tone);
        font-size: clamp(2rem, 6vw, 3.25rem);
        font-weight: 700;
        line-height: 1.05;
        letter-spacing: -0.02em;
      }
      /* Its card has an edge already. */
      .table {
        --t-columns: minmax(8rem, 2fr) minmax(5rem, 1fr) minmax(9rem, 3fr) 7rem minmax(6rem, 1fr);
        border-inline: 0;
        border-radius: 0;
      }
      .row {
        padding-inline: 0;
      }
      .titles {
        background: none;
      }
      @container (max-width: 54rem) {
        .row > :nth-child(even) {
          text-align: end;
        }
      }
    `,
  ];

  private readonly interlocks = new ContextStoreController(this, interlocksContext);

  override willUpdate(): void {
    this.observeSignals(...(this.device?.signals ?? []));
  }

  override render(): TemplateResult | typeof nothing {
    const { device, detail } = this;
    if (device === null || detail === null) return nothing;
    const store = this.interlocks.store;
    const { rules, lines, verdict } = judgeStation({
      rules: detail.rules,
      device,
      online: this.online,
      news: ({ id }) => store?.interlockOf(this.site, id)?.news,
      known: (signal) => this.readSignal(signal),
    });
    const left = rules.map(({ id }) => store?.interlockOf(this.site, id)).filter((interlock) => interlock?.news.locked === true && !interlock.news.unsafe);
    const clears = Math.max(0, ...left.map((interlock) => (interlock === undefined ? 0 : (store?.remainingMs(interlock, interlock.news.clears_ms) ?? 0))));
    return html`<section class="card verdict ${verdict.word}" aria-label=${msg("Verdict")} role="status">
        <svg viewBox="0 0 48 48" aria-hidden="true">${SHAPES[verdict.word]}</svg>
        <div>
          <p class="word">${VERDICT_WORDS[verdict.word]}</p>
          ${this.renderReason(verdict, clears)} ${this.renderOwnState()}
        </div>
      </section>
      ${lines.length === 0 ? nothing : this.renderTable(lines)}`;
  }

  private renderReason({ word, why, since_us, rule }: WeatherVerdict, clears: number): TemplateResult {
    if (word === "none") {
      return html`<p class="note">${msg("No interlock of this site reads this station, so that nothing here decides whether a roof may open.")}</p>`;
    }
    const until = word === "wait" ? msg(str` Released in ${formatDuration(Math.ceil(clears / 1000))} if it stays so.`) : "";
    return html`<p>${why}${until}</p>
      <p class="note">
        ${rule === "" ? (word === "safe" ? msg("All its rules agree.") : nothing) : msg(html`Decided by the rule <strong>${rule}</strong>.`)}
        ${since_us === 0 ? nothing : html` ${msg(html`Since <t-time short .us=${since_us} .zone=${this.detail?.zone ?? "UTC"}></t-time>.`)}`}
      </p>`;
  }

  /** What the station says of itself, where it has such a state. */
  private renderOwnState(): unknown {
    const own = signalWith(this.device ?? NO_DEVICE, "weather.safety");
    if (own === undefined) return nothing;
    const { fresh, word, value } = this.readSignal(own);
    const kind = (fresh ? OWN_KINDS[meaningOf(own, value)] : undefined) ?? "unknown";
    return html`<t-status kind=${kind} .word=${msg(str`The station itself says: ${fresh ? word : msg("unknown")}`)}></t-status>`;
  }

  private renderTable(lines: readonly LimitLine[]): TemplateResult {
    return html`<div class="card" role="group" aria-labelledby="limits">
      <h2 id="limits">${msg("What closes the roof")}</h2>
      ${renderTable({ label: msg("What closes the roof"), columns: COLUMNS, rows: lines, key: ({ rule, signal, limit }) => `${rule} ${signal} ${limit}` })}
      <p class="note">${msg("A value that is unknown or too old counts as unsafe. The gateway beside the roof decides, also without this hub.")}</p>
    </div>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-weather": WeatherPart;
  }
}
