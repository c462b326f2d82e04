/** Whether the weather lets the roof open, in large words, with the rule that decides and its numbers. */

import { css, html, nothing, svg, type SVGTemplateResult, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import type { InterlockUpdate } from "../../generated/wire.js";
import { base } from "../../elements/base/base-style.js";
import { formatDuration } from "../../format/duration.js";
import type { RuleShape, StateMeaning } from "../../generated/api.js";
import { interlocksContext } from "../../state/contexts.js";
import { NO_DEVICE, DevicePart, partStyle } from "./device-part.js";
import { meaningOf, signalWith } from "./roles.js";
import { limitLines, rulesAbout, verdictOf, type LimitLine, type WeatherVerdict, type VerdictWord, VERDICT_WORDS } from "./weather-verdict.js";
import "../../elements/feedback/status.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import "../../elements/values/time.js";
import "../signal-value.js";

/** How a station's own word is shown, by what it means. */
const OWN_KINDS: Readonly<Partial<Record<StateMeaning, StatusKind>>> = { safe: "ok", warning: "warn", unsafe: "bad" };
const STANDS: Readonly<Record<LimitLine["stands"], { kind: StatusKind; word: string }>> = {
  fine: { kind: "ok", word: "within" },
  beyond: { kind: "bad", word: "beyond" },
  returning: { kind: "warn", word: "near" },
  unknown: { kind: "unknown", word: "unknown" },
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

@customElement("t-part-weather")
export class WeatherPart extends DevicePart {
  static override styles = [
    base,
    partStyle,
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
      .table {
        overflow-x: auto;
      }
      table {
        inline-size: 100%;
        border-collapse: collapse;
        font-variant-numeric: tabular-nums;
      }
      th,
      td {
        padding: var(--t-space-2) var(--t-space-3) var(--t-space-2) 0;
        border-block-start: 1px solid var(--t-line);
        text-align: start;
        vertical-align: baseline;
      }
      thead th {
        border: 0;
        color: var(--t-muted);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight);
      }
      tbody th {
        font-weight: var(--t-weight-strong);
      }
      @media (max-width: 45rem) {
        thead {
          position: absolute;
          clip-path: inset(50%);
        }
        tbody tr {
          display: grid;
          grid-template-columns: minmax(0, 1fr) auto;
          padding-block: var(--t-space-2);
          border-block-start: 1px solid var(--t-line);
        }
        tbody :is(th, td) {
          padding: 0;
          border: 0;
        }
        tbody td:nth-child(2) {
          text-align: end;
          font-weight: var(--t-weight-strong);
        }
        tbody td:nth-child(4) {
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
    const rules = rulesAbout(detail.rules, device.id);
    const store = this.interlocks.store;
    const news = ({ id }: RuleShape): InterlockUpdate | undefined => store?.interlockOf(this.site, id)?.news;
    const lines = limitLines(rules, device.id, device.signals, (signal) => this.readSignal(signal), news);
    const verdict = verdictOf(this.online, rules, news, lines);
    const left = rules.map(({ id }) => store?.interlockOf(this.site, id)).filter((interlock) => interlock?.news.locked === true && !interlock.news.unsafe);
    const clears = Math.max(0, ...left.map((interlock) => (interlock === undefined ? 0 : (store?.remainingMs(interlock, interlock.news.clears_ms) ?? 0))));
    return html`<section class="card verdict ${verdict.word}" aria-label="Verdict" role="status">
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
      return html`<p class="note">No interlock of this site reads this station, so that nothing here decides whether a roof may open.</p>`;
    }
    const until = word === "wait" ? ` Released in ${formatDuration(Math.ceil(clears / 1000))} if it stays so.` : "";
    return html`<p>${why}${until}</p>
      <p class="note">
        ${rule === "" ? (word === "safe" ? "All its rules agree." : nothing) : html`Decided by the rule <strong>${rule}</strong>.`}
        ${since_us === 0 ? nothing : html` Since <t-time short .us=${since_us} .zone=${this.detail?.zone ?? "UTC"}></t-time>.`}
      </p>`;
  }

  /** What the station says of itself, where it has such a state. */
  private renderOwnState(): unknown {
    const own = signalWith(this.device ?? NO_DEVICE, "weather.safety");
    if (own === undefined) return nothing;
    const { fresh, word, value } = this.readSignal(own);
    const kind = (fresh ? OWN_KINDS[meaningOf(own, value)] : undefined) ?? "unknown";
    return html`<t-status kind=${kind} .word=${`The station itself says: ${fresh ? word : "unknown"}`}></t-status>`;
  }

  private renderTable(lines: readonly LimitLine[]): TemplateResult {
    return html`<section class="card" aria-labelledby="limits">
      <h2 id="limits">What closes the roof</h2>
      <div class="table">
        <table>
          <thead>
            <tr>
              <th scope="col">Value</th>
              <th scope="col">Now</th>
              <th scope="col">Unsafe</th>
              <th scope="col">It is</th>
              <th scope="col">Rule</th>
            </tr>
          </thead>
          <tbody>
            ${repeat(
              lines,
              (line) => `${line.rule} ${line.signal} ${line.limit}`,
              (line) => html`<tr>
                <th scope="row">${line.name}</th>
                <td>${line.now}</td>
                <td>${line.limit}</td>
                <td><t-status kind=${STANDS[line.stands].kind} .word=${STANDS[line.stands].word}></t-status></td>
                <td class="muted">${line.rule}</td>
              </tr>`,
            )}
          </tbody>
        </table>
      </div>
      <p class="note">A value that is unknown or too old counts as unsafe. The gateway beside the roof decides, also without this hub.</p>
    </section>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-part-weather": WeatherPart;
  }
}
