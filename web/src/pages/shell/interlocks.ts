/** The bar over every page: what interlocks lock, why and since when, and overrides while they last. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { LinkController } from "../../controllers/link.js";
import { StoreController } from "../../controllers/store.js";
import { TickController } from "../../controllers/tick.js";
import { base } from "../../elements/base.js";
import "../../elements/button.js";
import "../../elements/dialog.js";
import "../../elements/field.js";
import "../../elements/interlock.js";
import { formatDuration } from "../../format/duration.js";
import type { InterlockNews } from "../../generated/wire.js";
import { interlocksContext, sitesContext } from "../../state/contexts.js";
import type { Interlock } from "../../state/interlocks.js";

const MINUTE_S = 60;

@customElement("t-interlocks")
export class InterlockBar extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
      form {
        display: grid;
        gap: var(--t-space-3);
      }
    `,
  ];

  @state() private chosen: InterlockNews | null = null;
  @state() private problem = "";
  @query("input[name=reason]") private readonly reason!: HTMLInputElement | null;
  @query("input[name=minutes]") private readonly minutes!: HTMLInputElement | null;

  private readonly interlocks = new StoreController(this, interlocksContext);
  private readonly sites = new StoreController(this, sitesContext);
  private readonly link = new LinkController(this, (connection) => [
    connection.on("problem", (news) => {
      if (news.about === "override") this.problem = news.message;
    }),
  ]);

  constructor() {
    super();
    new TickController(this, 1000);
  }

  override render(): TemplateResult | typeof nothing {
    const list = this.interlocks.store?.list ?? [];
    if (list.length === 0 && this.chosen === null) return nothing;
    return html`
      ${repeat(list, ({ news }) => `${news.site} ${news.interlock}`, (one) => this.line(one))} ${this.dialog()}
    `;
  }

  private line(one: Interlock): TemplateResult {
    const { news } = one;
    const store = this.interlocks.store;
    const row = this.sites.store?.row(news.site);
    const many = (this.sites.store?.list.length ?? 0) > 1;
    const override = (): void => {
      this.problem = "";
      this.chosen = news;
    };
    const end = (): void => {
      this.send(news, 0, "");
    };
    return html`<t-interlock
      .news=${news}
      .site=${many ? (row?.name ?? news.site) : ""}
      .zone=${row?.zone ?? "UTC"}
      .clears=${store?.left(one, news.clears_ms) ?? 0}
      .override_=${store?.left(one, news.override_ms) ?? 0}
      @t-override=${override}
      @t-end-override=${end}
    ></t-interlock>`;
  }

  private dialog(): TemplateResult {
    const longest = this.chosen?.longest_s ?? 0;
    return html`<t-dialog
      heading="Override ${this.chosen?.name ?? "interlock"}?"
      ?open=${this.chosen !== null}
      @t-close=${this.close}
    >
      <form novalidate @submit=${this.submitted}>
        <p>
          The gateway will refuse nothing for this reason until the time is over, and then act again if it is still
          unsafe. Everybody sees who did this and why.
        </p>
        <t-field label="Reason" .error=${this.problem}><input name="reason" type="text" maxlength="500" autocomplete="off" /></t-field>
        <t-field label="Minutes" hint="At most ${formatDuration(longest)}">
          <input name="minutes" type="text" inputmode="decimal" autocomplete="off" value="10" />
        </t-field>
      </form>
      <t-button slot="actions" @click=${this.close}>Keep it locked</t-button>
      <t-button slot="actions" kind="danger" @click=${this.submitted}>Override</t-button>
    </t-dialog>`;
  }

  private readonly close = (): void => {
    this.chosen = null;
  };

  private readonly submitted = (event: Event): void => {
    event.preventDefault();
    const { chosen } = this;
    if (!chosen) return;
    const reason = this.reason?.value.trim() ?? "";
    const seconds = Number(this.minutes?.value.replace(",", ".") ?? Number.NaN) * MINUTE_S;
    if (reason === "") this.problem = "Say why: it is written down and shown to everybody.";
    else if (!(seconds > 0 && seconds <= chosen.longest_s)) {
      this.problem = `Give more than 0 and at most ${formatDuration(chosen.longest_s)}.`;
    } else {
      this.send(chosen, seconds, reason);
      this.chosen = null;
    }
  };

  private send(news: InterlockNews, seconds: number, reason: string): void {
    this.link.connection?.send({ t: "override", site: news.site, interlock: news.interlock, seconds, reason });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-interlocks": InterlockBar;
  }
}
