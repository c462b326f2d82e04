/**
 * The bar over a page: what interlocks of its site lock, why and since when, and overrides of any site while they last.
 *
 * Where something is driven or commanded it is one line of one height, also while nothing is locked: an interlock
 * that locks or lets go must not move the page under a driver's thumb. On other pages it comes when there is
 * something to say. All of them unfold when somebody asks for them.
 */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/confirm.js";
import { forms } from "../../elements/forms/form-style.js";
import "../../elements/forms/field.js";
import "../../elements/base/icon.js";
import "../../elements/command/interlock.js";
import { formatDuration } from "../../format/duration.js";
import type { InterlockUpdate } from "../../generated/wire.js";
import { interlocksContext, sitesContext } from "../../state/contexts.js";
import type { Interlock } from "../../state/interlocks.js";

const MINUTE_S = 60;

@customElement("t-interlocks")
export class InterlockBar extends LitElement {
  static override styles = [
    base,
    forms,
    css`
      :host {
        display: block;
        position: relative;
      }
      .strip {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        block-size: max(var(--t-touch), 2.5rem);
        padding-inline: var(--t-space-4);
        border-block-end: 1px solid var(--t-line);
        border-inline-start: 4px solid var(--t-line);
        background: var(--t-raised);
        color: var(--t-muted);
      }
      .strip.locked {
        border-inline-start-color: var(--t-warn);
        color: var(--t-text);
      }
      .strip.unsafe {
        border-inline-start-color: var(--t-bad);
        color: var(--t-text);
      }
      .locked t-icon {
        color: var(--t-warn);
      }
      .unsafe t-icon {
        color: var(--t-bad);
      }
      .first {
        flex: 1 1 0;
        min-inline-size: 0;
        overflow: hidden;
        text-overflow: ellipsis;
        white-space: nowrap;
      }
      .count {
        flex: none;
        ${quietText}
      }
      /* In its place, not over the page: it would lie on STOP. */
      .all {
        max-block-size: 40dvh;
        overflow: auto;
      }
    `,
  ];

  /** The site that the page shows; empty for pages of all sites. */
  @property() site = "";
  /** The line keeps its place while nothing is locked. */
  @property({ type: Boolean }) steady = false;
  @state() private chosen: InterlockUpdate | null = null;
  @state() private unfolded = false;
  /** The sites of which there was something to say: there a steady line keeps its place. */
  private readonly placed = new Set<string>();
  @state() private problem = "";
  @query("input[name=reason]") private readonly reason!: HTMLInputElement | null;
  @query("input[name=minutes]") private readonly minutes!: HTMLInputElement | null;

  private readonly interlocks = new ContextStoreController(this, interlocksContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly link = new ConnectionStateController(this, (connection) => [
    connection.onMessage("problem", (news) => {
      if (news.about === "override") this.problem = news.message;
    }),
  ]);

  constructor() {
    super();
    new TickerController(this, 1000);
  }

  override willUpdate(): void {
    if (this.interlocks.store?.hasAny(this.site) === true) this.placed.add(this.site);
  }

  override render(): TemplateResult | typeof nothing {
    const store = this.interlocks.store;
    const list = store?.listAt(this.site) ?? [];
    const kept = this.steady && this.placed.has(this.site);
    if (!kept && list.length === 0 && this.chosen === null) return nothing;
    const unfolded = this.unfolded && list.length > 0;
    return html`
      ${this.renderStrip(list, unfolded)}
      <div class="all" id="all" ?hidden=${!unfolded}>
        ${repeat(list, ({ news }) => `${news.site} ${news.interlock}`, (interlock) => this.renderLine(interlock))}
      </div>
      ${this.renderDialog()}
    `;
  }

  private renderStrip(list: readonly Interlock[], unfolded: boolean): TemplateResult {
    const first = list[0]?.news;
    if (first === undefined) {
      const known = this.interlocks.store?.hasAny(this.site) === true;
      return html`<div class="strip" role="status">
        <t-icon name="lock"></t-icon>
        <span class="first">${known ? msg("Interlocks: nothing is locked.") : msg("Interlocks: not known now.")}</span>
      </div>`;
    }
    const severe = list.some(({ news }) => news.unsafe || news.overridden_by !== "");
    const more = list.length - 1;
    return html`<div class="strip ${severe ? "unsafe" : "locked"}">
      <t-icon name=${first.overridden_by === "" ? "lock" : "warn"}></t-icon>
      <span class="first" role="status">${this.summary(first)}</span>
      ${more > 0 ? html`<span class="count">${msg(str`and ${more} more`)}</span>` : nothing}
      <t-button kind="quiet" label=${unfolded ? msg("Hide interlocks") : msg("Show interlocks")} @click=${this.toggleList}
        >${unfolded ? msg("Hide") : msg("Show")}</t-button
      >
    </div>`;
  }

  private summary(news: InterlockUpdate): string {
    const row = this.sites.store?.siteRow(news.site);
    const many = (this.sites.store?.list.length ?? 0) > 1;
    const name = `${many ? `${row?.name ?? news.site}: ` : ""}${news.name}`;
    if (news.overridden_by !== "") return msg(str`${name} – overridden by ${news.overridden_by}: “${news.reason}”`);
    return `${name} – ${news.unsafe ? news.why || msg("unsafe now") : msg("safe now, released soon if it stays so")}`;
  }

  private readonly toggleList = (): void => {
    this.unfolded = !this.unfolded;
  };

  private renderLine(interlock: Interlock): TemplateResult {
    const { news } = interlock;
    const store = this.interlocks.store;
    const row = this.sites.store?.siteRow(news.site);
    const many = (this.sites.store?.list.length ?? 0) > 1;
    const askOverride = (): void => {
      this.problem = "";
      this.chosen = news;
    };
    const endOverride = (): void => {
      this.sendOverride(news, 0, "");
    };
    return html`<t-interlock
      .news=${news}
      .site=${many ? (row?.name ?? news.site) : ""}
      .zone=${row?.zone ?? "UTC"}
      .clears=${store?.remainingMs(interlock, news.clears_ms) ?? 0}
      .override_=${store?.remainingMs(interlock, news.override_ms) ?? 0}
      @t-override=${askOverride}
      @t-end-override=${endOverride}
    ></t-interlock>`;
  }

  private renderDialog(): TemplateResult {
    const longest = this.chosen?.longest_s ?? 0;
    return html`<t-confirm
      heading=${msg(str`Override ${this.chosen?.name ?? msg("interlock")}?`)}
      action=${msg("Override")}
      keep=${msg("Keep it locked")}
      ?open=${this.chosen !== null}
      @t-close=${this.close}
      @t-confirm=${this.onSubmit}
    >
      <form novalidate @submit=${this.onSubmit}>
        <p>
          ${msg(html`<strong>${this.chosen?.why || msg("Safe now, but not for long enough yet")}.</strong> Only this is overridden: the gateway will refuse nothing for it until the time is over, and then act again if it is still unsafe. The override ends early when anything else locks, or when this becomes unknown. Everybody sees who did this and why.`)}
        </p>
        <t-field label=${msg("Reason")} .error=${this.problem}><input name="reason" type="text" maxlength="500" autocomplete="off" /></t-field>
        <t-field label=${msg("Minutes")} hint=${msg(str`At most ${formatDuration(longest)}`)}>
          <input name="minutes" type="text" inputmode="decimal" autocomplete="off" value="10" />
        </t-field>
      </form>
    </t-confirm>`;
  }

  private readonly close = (): void => {
    this.chosen = null;
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    const { chosen } = this;
    if (!chosen) return;
    const reason = this.reason?.value.trim() ?? "";
    const seconds = Number(this.minutes?.value.replace(",", ".") ?? Number.NaN) * MINUTE_S;
    if (reason === "") this.problem = msg("Say why: it is written down and shown to everybody.");
    else if (!(seconds > 0 && seconds <= chosen.longest_s)) {
      this.problem = msg(str`Give more than 0 and at most ${formatDuration(chosen.longest_s)}.`);
    } else {
      this.sendOverride(chosen, seconds, reason, chosen.condition);
      this.chosen = null;
    }
  };

  private sendOverride(news: InterlockUpdate, seconds: number, reason: string, condition = ""): void {
    const { site, interlock } = news;
    this.link.connection?.send({ t: "override", site, interlock, seconds, reason, condition });
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-interlocks": InterlockBar;
  }
}
