/** What of alarms a person wants to be told, by which way, and when not. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { StoreController } from "../../controllers/store.js";
import { base } from "../../elements/base.js";
import { sheets } from "../../elements/sheets.js";
import { adviceFor } from "../../format/problem.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { NotifyApi, type PushList, type RuleAsk, type NoticeRuleShape, type WayChoice, type WentShape } from "../../wire/alarms.js";
import type { HubApi } from "../../wire/http.js";
import { subscribe, whyNoPush } from "../../wire/push.js";
import "../../elements/button.js";
import "../../elements/field.js";
import "../../elements/loading.js";
import "../../elements/problem.js";
import "../../elements/status.js";

interface Known {
  readonly ways: readonly WayChoice[];
  readonly rules: readonly NoticeRuleShape[];
  readonly push: PushList;
}

const SEVERITIES = ["info", "warning", "critical"] as const;

@customElement("t-account-rules")
export class AccountRules extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      form {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(14rem, 100%), 1fr));
        align-items: end;
        gap: var(--t-space-3);
      }
      label.tick {
        display: flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
      }
      .went {
        overflow-wrap: anywhere;
      }
    `,
  ];

  @state() private adding = false;
  @state() private way = "";
  @state() private went: { readonly id: string; readonly how: WentShape } | null = null;
  @query("form") private readonly form!: HTMLFormElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new StoreController(this, sitesContext);
  private readonly known = new LoadController<Known>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.known.ask("rules", async () => {
      const api = new NotifyApi(this.api);
      const [{ ways }, { rules }, push] = await Promise.all([api.choices(), api.rules(), api.push()]);
      return { ways, rules, push };
    });
  }

  override render(): TemplateResult {
    const { result, value } = this.known;
    const advice = result.state === "failed" ? adviceFor(result.error, "your rules") : null;
    return html`<h2>Messages about alarms</h2>
      ${advice === null ? nothing : html`<t-problem what=${advice.what} how=${advice.how}></t-problem>`}
      ${value === undefined ? (advice === null ? html`<t-loading what="Loading your rules"></t-loading>` : nothing) : this.content(value)}
      ${this.action.problem === null
        ? nothing
        : html`<t-problem what=${this.action.problem.what} how=${this.action.problem.how}></t-problem>`}`;
  }

  private content(known: Known): TemplateResult {
    if (known.ways.length === 0) {
      return html`<p class="muted">Nobody is told of alarms yet: an admin sets up mail, a webhook, a chat or push messages first, under Admin, Notification.</p>`;
    }
    return html`${known.rules.length === 0
        ? html`<p class="muted">You are told of no alarms. They are on every page all the same.</p>`
        : html`<ul class="rows">
            ${repeat(
              known.rules,
              ({ id }) => id,
              (rule) => this.rule(rule, known),
            )}
          </ul>`}
      ${this.adding ? this.wish(known) : html`<div class="actions"><t-button @click=${this.add}>Tell me of alarms…</t-button></div>`}
      ${known.push.key === "" ? nothing : this.browsers(known.push)}`;
  }

  private rule(rule: NoticeRuleShape, known: Known): TemplateResult {
    const way = known.ways.find(({ id }) => id === rule.way);
    const site = rule.site === "*" ? "every site" : (this.sites.store?.row(rule.site)?.name ?? rule.site);
    const quiet = rule.quiet_from === rule.quiet_to ? "" : `quiet ${clock(rule.quiet_from ?? 0)}–${clock(rule.quiet_to ?? 0)} (${rule.zone ?? "UTC"}) but for ${rule.quiet_least ?? "critical"}`;
    return html`<li>
      <div>
        <div class="name">${way?.name ?? "a way that is gone"}${rule.target === "" ? "" : ` to ${rule.target ?? ""}`}</div>
        <div class="facts">
          <span>${site}</span><span>${rule.least} and worse</span>${rule.over === true ? html`<span>also when it is over</span>` : nothing}
          ${quiet === "" ? nothing : html`<span>${quiet}</span>`}
        </div>
        ${this.went?.id === rule.id
          ? html`<div class="went" role="status">
              ${this.went.how.sent ? html`<t-status kind="ok" word="the test was taken"></t-status>` : html`<t-status kind="bad" word="not sent"></t-status> ${this.went.how.problem}`}
            </div>`
          : nothing}
      </div>
      <div class="actions">
        <t-button ?busy=${this.action.under === `test ${rule.id}`} @click=${this.tester(rule.id)}>Send a test</t-button>
        <t-button @click=${this.remover(rule.id)}>Remove</t-button>
      </div>
    </li>`;
  }

  private wish(known: Known): TemplateResult {
    const way = known.ways.find(({ id }) => id === this.way) ?? known.ways[0];
    return html`<form novalidate @submit=${this.submitted}>
        <t-field label="By">
          <select name="way" @change=${this.choose}>
            ${map(known.ways, (one) => html`<option value=${one.id} ?selected=${one.id === way?.id}>${one.name}</option>`)}
          </select>
        </t-field>
        ${way?.kind === "mail" ? html`<t-field label="Mail address"><input name="target" type="email" maxlength="200" autocomplete="email" /></t-field>` : nothing}
        <t-field label="Of">
          <select name="site">
            <option value="*">every site</option>
            ${map(this.sites.store?.list ?? [], ({ site, name }) => html`<option value=${site}>${name}</option>`)}
          </select>
        </t-field>
        <t-field label="At least">
          <select name="least">
            ${map(SEVERITIES, (word) => html`<option ?selected=${word === "warning"}>${word}</option>`)}
          </select>
        </t-field>
        <t-field label="Quiet from" hint="Empty: never quiet"><input name="from" type="time" /></t-field>
        <t-field label="Quiet until" hint="What comes meanwhile is told then"><input name="to" type="time" /></t-field>
        <t-field label="Told in quiet hours too">
          <select name="quiet_least">
            ${map(SEVERITIES.slice(1), (word) => html`<option ?selected=${word === "critical"}>${word}</option>`)}
          </select>
        </t-field>
        <t-field label="Gathered for (s)" hint="A burst comes as one message"><input name="group_s" inputmode="numeric" value="10" /></t-field>
        <label class="tick"><input name="over" type="checkbox" checked /> Also when it is over</label>
      </form>
      <div class="actions">
        <t-button kind="primary" ?busy=${this.action.busy} @click=${this.submitted}>Tell me</t-button>
        <t-button @click=${this.cancel}>Cancel</t-button>
      </div>`;
  }

  private browsers(push: PushList): TemplateResult {
    const why = whyNoPush();
    return html`<h3>Browsers that take push messages</h3>
      <ul class="rows">
        ${repeat(
          push.browsers,
          ({ id }) => id,
          (one) => html`<li><div class="facts">${one.agent}</div><t-button @click=${this.forgetter(one.id)}>Remove</t-button></li>`,
        )}
      </ul>
      ${why === ""
        ? html`<div class="actions"><t-button ?busy=${this.action.under === "push"} @click=${this.take(push.key)}>Take messages in this browser</t-button></div>`
        : html`<p class="muted">${why}</p>`}`;
  }

  private readonly add = (): void => {
    this.action.clear();
    this.adding = true;
  };

  private readonly cancel = (): void => {
    this.adding = false;
  };

  private readonly choose = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.way = event.target.value;
  };

  private readonly submitted = (event: Event): void => {
    event.preventDefault();
    if (this.form === null) return;
    const data = new FormData(this.form);
    const text = (key: string): string => {
      const value = data.get(key);
      return typeof value === "string" ? value.trim() : "";
    };
    const [from, to] = [minutes(text("from")), minutes(text("to"))];
    const rule: RuleAsk = {
      site: text("site"), way: text("way"), target: text("target"), least: severity(text("least")), over: data.has("over"),
      quiet_from: from ?? 0, quiet_to: from === null ? 0 : (to ?? 0), quiet_least: severity(text("quiet_least")),
      zone: Intl.DateTimeFormat().resolvedOptions().timeZone, group_s: Math.round(Number(text("group_s")) || 0),
    };
    void this.action.run("keep the rule", () => new NotifyApi(this.api).addRule(rule)).then((done) => {
      if (done) this.adding = false;
      this.known.again();
    });
  };

  private tester(id: string): () => void {
    return () => {
      this.went = null;
      void this.action.run(
        "send the test",
        async () => {
          this.went = { id, how: await new NotifyApi(this.api).testRule(id) };
        },
        "",
        `test ${id}`,
      );
    };
  }

  private remover(id: string): () => void {
    return () => {
      void this.action.run("remove the rule", () => new NotifyApi(this.api).removeRule(id)).then(() => {
        this.known.again();
      });
    };
  }

  private forgetter(id: string): () => void {
    return () => {
      void this.action.run("remove the browser", () => new NotifyApi(this.api).removeBrowser(id)).then(() => {
        this.known.again();
      });
    };
  }

  private take(key: string): () => void {
    return () => {
      void this.action
        .run("take messages in this browser", async () => new NotifyApi(this.api).addBrowser(await subscribe(key)), "", "push")
        .then(() => {
          this.known.again();
        });
    };
  }
}

function severity(word: string): "info" | "warning" | "critical" {
  return SEVERITIES.find((one) => one === word) ?? "warning";
}

/** Minute of the day of `HH:MM`; null when there is none. */
function minutes(text: string): number | null {
  const match = /^(\d\d):(\d\d)/.exec(text);
  return match === null ? null : Number(match[1]) * 60 + Number(match[2]);
}

function clock(minute: number): string {
  return `${String(Math.floor(minute / 60)).padStart(2, "0")}:${String(minute % 60).padStart(2, "0")}`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-rules": AccountRules;
  }
}
