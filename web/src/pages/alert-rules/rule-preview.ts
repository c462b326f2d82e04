/** What a rule that is being typed would have made of the notices that came last. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderTable, tables } from "../../elements/layout/data-table.js";
import { adviceFor } from "../../format/error-advice.js";
import { formatDec, formatRa } from "../../format/sexagesimal.js";
import type { AlertPreview, AlertPreviewLine, AlertRuleAsk } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { AlertRulesApi } from "../../wire/alert-rules-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/feedback/status.js";
import "../../elements/values/time.js";

/** So long nothing may be typed before the hub is asked (ms). */
const PAUSE_MS = 600;

@customElement("t-alert-rule-preview")
export class AlertRulePreview extends LitElement {
  static override styles = [
    base,
    tables,
    css`
      :host {
        display: grid;
        gap: var(--t-space-3);
        --t-columns: 9rem minmax(8rem, 1fr) minmax(9rem, 1fr) 9rem minmax(10rem, 2fr);
      }
    `,
  ];

  @property() site = "";
  @property() proposal = "";
  /** Null while it cannot be tried. */
  @property({ attribute: false }) asked: AlertRuleAsk | null = null;
  @property() zone = "UTC";
  /** What the hub is asked, as JSON; empty for nothing. */
  @state() private question = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly answer = new LoadController<AlertPreview | null>(this);
  private typed = "";
  private timer: ReturnType<typeof setTimeout> | undefined;

  override willUpdate(): void {
    const typed = this.asked === null ? "" : JSON.stringify(this.asked);
    if (typed !== this.typed) {
      this.typed = typed;
      clearTimeout(this.timer);
      this.timer = setTimeout(() => {
        this.question = typed;
      }, PAUSE_MS);
    }
    const { asked, question } = this;
    if (question !== typed) return;
    this.answer.load(`${this.site} ${this.proposal} ${question}`, async () => (asked === null ? null : new AlertRulesApi(this.api, this.site, this.proposal).previewRule(asked)));
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearTimeout(this.timer);
    this.typed = "";
  }

  override render(): TemplateResult {
    const { result, value } = this.answer;
    if (this.typed === "") return html`<p class="muted">${msg("It is tried once everything that it needs is written.")}</p>`;
    if (result.state === "failed") return html`<div>${renderAdvice(adviceFor(result.error, msg("what this rule would have made")), this.answer.invalidate)}</div>`;
    if (value === undefined || value === null) return html`<p class="muted">${msg("Trying it …")}</p>`;
    const isNow = this.question === this.typed && result.state === "ready";
    const message = value.message.charAt(0).toUpperCase() + value.message.slice(1);
    return html`<p role="status" aria-busy=${isNow ? "false" : "true"}><strong>${message}.</strong>${isNow ? nothing : html` <span class="muted">${msg("(before the last change)")}</span>`}</p>
      ${value.notices.length === 0 ? nothing : this.renderNotices(value.notices)}`;
  }

  private renderNotices(notices: readonly AlertPreviewLine[]): TemplateResult {
    return renderTable<AlertPreviewLine, string>({
      label: msg("The last notices"),
      rows: notices,
      key: ({ id }) => id,
      columns: [
        { title: msg("Came"), cell: ({ received_us: time }) => html`<t-time .us=${time} .zone=${this.zone}></t-time>` },
        { title: msg("Event"), heads: true, cell: ({ event, source }) => html`${event} <span class="muted small">${source}</span>` },
        { title: msg("Place (J2000)"), titled: true, cell: ({ ra, dec }) => (ra === null || dec === null ? msg("none", { id: "none.place" }) : `${formatRa(ra / 15)} ${formatDec(dec)}`) },
        { title: msg("Request"), cell: ({ passes }) => html`<t-status kind=${passes ? "ok" : "unknown"} word=${passes ? msg("would be made") : msg("none", { id: "none.request" })}></t-status>` },
        { title: msg("Why"), cell: ({ why }) => why },
      ],
    });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-alert-rule-preview": AlertRulePreview;
  }
}
