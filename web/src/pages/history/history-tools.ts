/** Which stretch of time the history page shows: quick ranges, from and to, zoom, follow. */

import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, queryAll, state } from "lit/decorators.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { knownZone, localSpan, zoneName } from "../../format/time.js";
import { lengthOf, panned, zoomed, type TimeSpan } from "../../series/time-window.js";
import { clockOf, type ZoneClock } from "../../series/zone-clock.js";
import { QUICK, quickOf, quickShown, spanOf, type HistoryView } from "./history-query.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";

type ShownRange = HistoryView["shown"];


/** @fires t-shown detail is what is asked to be shown */
@customElement("t-history-tools")
export class HistoryTools extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-3);
      }
      .dates,
      .moves {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-2);
      }
      summary {
        min-block-size: var(--t-touch);
        align-content: center;
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
        font-variant-numeric: tabular-nums;
        cursor: pointer;
      }
      label {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        ${quietText}
        font-weight: var(--t-weight-strong);
      }
      input {
        min-block-size: var(--t-touch);
        padding: var(--t-space-1) var(--t-space-2);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        font-size: var(--t-size-s);
        font-variant-numeric: tabular-nums;
      }
      @media (pointer: coarse) {
        /* Smaller, and a phone zooms in on it. */
        input {
          font-size: var(--t-size-m);
        }
      }
      input[aria-invalid="true"] {
        border: 2px solid var(--t-bad);
      }
      .zone {
        ${quietText}
      }
      .wrong {
        inline-size: 100%;
        color: var(--t-bad);
        font-size: var(--t-size-s);
        font-weight: var(--t-weight-strong);
      }
      .moves {
        gap: var(--t-space-1);
        font-variant-numeric: tabular-nums;
      }
      @media (min-width: 45.01rem) {
        summary {
          display: none;
        }
        /* The two fields and the dash between them say it; the words are for who listens. */
        .dates label span {
          position: absolute;
          clip-path: inset(50%);
        }
        .dates label + label::before {
          content: "–";
        }
        .dates input {
          inline-size: 15rem;
        }
      }
      @media (min-width: 45.01rem) and (pointer: coarse) {
        .dates input {
          inline-size: 18.5rem;
        }
      }
      @media (max-width: 45rem) {
        /* Eight ranges: two even rows. */
        t-choice {
          --t-choice-basis: 22%;
        }
        .when,
        t-choice {
          inline-size: 100%;
        }
        .moves t-button {
          flex: 1 0 auto;
        }
        .moves {
          inline-size: 100%;
        }
        label {
          inline-size: 100%;
        }
        label span {
          inline-size: 2.5rem;
        }
        input {
          flex: 1;
          min-inline-size: 0;
        }
      }
    `,
  ];

  @property({ attribute: false }) shown: ShownRange = { last: 900 };
  /** The window that is on screen now. */
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  @property() zone = "UTC";

  @queryAll("input") private readonly inputs!: NodeListOf<HTMLInputElement>;

  private readonly wide = matchMedia("(min-width: 45.01rem)");

  @state() private wrong = "";

  override render(): TemplateResult {
    const clock = this.clock();
    const follows = "last" in this.shown;
    return html`
      <t-choice
        label=${msg("Time range")}
        .options=${QUICK}
        chosen=${quickOf(this.shown, Date.now() * 1000, clock)}
        @t-choose=${this.onQuickRange}
      ></t-choice>
      <details class="when" ?open=${this.wide.matches}>
        <summary>${this.spanText(clock)}</summary>
        <div class="dates" @change=${this.onInput}>
          ${this.renderDateField(msg("From", { id: "from.time" }), clock.toInput(this.span.fromUs))} ${this.renderDateField(msg("To", { id: "to.time" }), clock.toInput(this.span.toUs))}
          <span class="zone" title=${clock.zone}>${zoneName(this.span.toUs, clock.zone)}</span>
        </div>
      </details>
      <div class="moves">
        <t-button label=${msg("Earlier")} @click=${this.moveEarlier}>←</t-button>
        <t-button label=${msg("Later")} @click=${this.moveLater}>→</t-button>
        <t-button label=${msg("Zoom in")} @click=${this.zoomIn}>+</t-button>
        <t-button label=${msg("Zoom out")} @click=${this.zoomOut}>−</t-button>
        <t-button pressed=${follows ? "true" : "false"} kind=${follows ? "primary" : "plain"} @click=${this.toggleFollow}
          >${follows ? msg("Following live") : msg("Follow live")}</t-button
        >
      </div>
      <span class="wrong" role="alert" ?hidden=${this.wrong === ""}>${this.wrong}</span>
    `;
  }

  private renderDateField(name: string, value: string): TemplateResult {
    const invalid = this.wrong === "" ? "false" : "true";
    return html`<label
      ><span>${name}</span><input type="text" autocomplete="off" placeholder="2026-03-29 14:05:09" maxlength="30" aria-invalid=${invalid} .value=${value}
    /></label>`;
  }

  private spanText(clock: ZoneClock): string {
    return localSpan(this.span, clock.zone, Date.now() * 1000);
  }

  private clock(): ZoneClock {
    return clockOf(knownZone(this.zone));
  }

  private readonly onQuickRange = (event: CustomEvent<string>): void => {
    this.fireWindowChange(quickShown(event.detail, Date.now() * 1000, this.clock()));
  };

  private readonly onInput = (): void => {
    const clock = this.clock();
    const [fromUs, toUs] = [...this.inputs].map((input) => clock.fromInput(input.value));
    if (fromUs === undefined || toUs === undefined || Number.isNaN(fromUs) || Number.isNaN(toUs)) {
      this.wrong = msg("Give both times, with date and clock.");
      return;
    }
    this.wrong = fromUs < toUs ? "" : msg("“From” must be before “to”.");
    if (this.wrong === "") this.fireWindowChange({ fromUs, toUs });
  };

  private readonly moveEarlier = (): void => {
    this.fireWindowChange(panned(this.span, -lengthOf(this.span) / 2));
  };

  private readonly moveLater = (): void => {
    this.fireWindowChange(panned(this.span, lengthOf(this.span) / 2));
  };

  private readonly zoomIn = (): void => {
    this.fireWindowChange(zoomed(this.span, 0.5, (this.span.fromUs + this.span.toUs) / 2));
  };

  private readonly zoomOut = (): void => {
    this.fireWindowChange(zoomed(this.span, 2, (this.span.fromUs + this.span.toUs) / 2));
  };

  /** From a window that stands still to one of the same length that goes on, and back. */
  private readonly toggleFollow = (): void => {
    if ("last" in this.shown) this.fireWindowChange(spanOf(this.shown, this.span.toUs));
    else this.fireWindowChange({ last: Math.max(1, Math.round(lengthOf(this.span) / 1e6)) });
  };

  private fireWindowChange(detail: ShownRange): void {
    this.wrong = "";
    this.dispatchEvent(new CustomEvent("t-shown", { detail }));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-history-tools": HistoryTools;
  }
  interface HTMLElementEventMap {
    "t-shown": CustomEvent<ShownRange>;
  }
}
