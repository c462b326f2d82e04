import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import type { InterlockUpdate } from "../../generated/wire.js";
import { formatDuration } from "../../format/duration.js";
import { base, quietText } from "../base/base-style.js";
import "../forms/button.js";
import "../base/icon.js";
import "../values/time.js";

/**
 * One interlock, while it locks something or is overridden: what, why, since when, until when.
 *
 * @fires t-override this person wants to override it
 * @fires t-end-override this person wants the override to end
 */
@customElement("t-interlock")
export class InterlockLine extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        flex-wrap: wrap;
        align-items: center;
        gap: var(--t-space-1) var(--t-space-3);
        padding: var(--t-space-1) var(--t-space-4);
        border-block-end: 1px solid var(--t-line);
        border-inline-start: 4px solid var(--t-warn);
        background: var(--t-raised);
        color: var(--t-text);
      }
      :host([kind="bad"]) {
        border-inline-start-color: var(--t-bad);
      }
      t-icon {
        color: var(--t-warn);
      }
      :host([kind="bad"]) t-icon {
        color: var(--t-bad);
      }
      .said {
        flex: 1 1 16rem;
        min-inline-size: 0;
      }
      .more {
        ${quietText}
      }
    `,
  ];

  @property({ attribute: false }) news: InterlockUpdate | null = null;
  /** The site by its name, where more than one is seen. */
  @property() site = "";
  @property() zone = "UTC";
  /** What is left of the dwell time and of the override (ms). */
  @property({ type: Number }) clears = 0;
  @property({ type: Number }) override_ = 0;
  @property({ reflect: true }) kind: "warn" | "bad" = "warn";

  override connectedCallback(): void {
    super.connectedCallback();
    this.setAttribute("role", "status");
  }

  override willUpdate(): void {
    this.kind = this.news?.unsafe === true || this.news?.overridden_by !== "" ? "bad" : "warn";
  }

  override render(): TemplateResult | typeof nothing {
    const { news } = this;
    if (!news) return nothing;
    const over = news.overridden_by !== "";
    return html`<t-icon name=${over ? "warn" : "lock"}></t-icon>
      <span class="said">
        <strong>${this.site === "" ? "" : `${this.site}: `}${news.name}</strong>
        ${over ? this.renderOverridden(news) : this.renderLocked(news)}
      </span>
      ${news.longest_s <= 0
        ? nothing
        : html`<t-button kind="quiet" @click=${over ? this.fireEndOverride : this.fireOverride}
            >${over ? msg("End override") : msg("Override…")}</t-button
          >`}`;
  }

  private renderLocked(news: InterlockUpdate): TemplateResult {
    const refused = news.refuses.length === 0 ? "" : msg(str` Refused: ${news.refuses.join(", ")}.`);
    const slowed = news.slows.length === 0 ? "" : msg(str` Slowed down: ${news.slows.join(", ")}.`);
    // What only slows down locks nothing.
    const since = html`<t-time .us=${news.since_us} .zone=${this.zone} short></t-time>`;
    const stands = news.refuses.length === 0 && slowed !== "" ? msg(html`So since ${since}.`) : msg(html`Locked since ${since}.`);
    const state = news.unsafe
      ? `${news.why || msg("unsafe now")}.`
      : msg(str`safe now; released in ${formatDuration(Math.ceil(this.clears / 1000))} if it stays so.`);
    const never = news.no_override === "" ? "" : msg(str` Not to be overridden now: ${news.no_override}.`);
    return html`– ${state}
      <span class="more">${stands}${refused}${slowed}${never}</span>`;
  }

  private renderOverridden(news: InterlockUpdate): TemplateResult {
    const left = formatDuration(Math.ceil(this.override_ / 1000));
    const unsafe = news.unsafe ? msg(str` Unsafe now: ${news.why}.`) : "";
    return html`${msg(str`– overridden by ${news.overridden_by} for ${left} more: “${news.reason}”.`)}
      <span class="more">${msg("It refuses and slows nothing meanwhile.")}${unsafe}</span>`;
  }

  private readonly fireOverride = (): void => {
    this.dispatchEvent(new CustomEvent("t-override"));
  };

  private readonly fireEndOverride = (): void => {
    this.dispatchEvent(new CustomEvent("t-end-override"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-interlock": InterlockLine;
  }
}
