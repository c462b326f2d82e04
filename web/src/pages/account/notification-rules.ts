/** What of alarms a person wants to be told, by which way, and when not. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TestMessageController } from "../../controllers/test-message.js";
import { base } from "../../elements/base/base-style.js";
import { renderRows } from "../../elements/layout/rows.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { browserName } from "../../format/user-agent.js";
import { apiContext, sitesContext } from "../../state/contexts.js";
import { NotifyApi } from "../../wire/alarms-api.js";
import type { NoticeRuleShape, PushList, RuleAsk, WayChoice } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { subscribePush, whyNoPush } from "../../wire/web-push.js";
import { quietHours } from "./notification-rule.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";
import "../../elements/feedback/delivery-result.js";
import "./notification-rule-form.js";

interface LoadedRules {
  readonly ways: readonly WayChoice[];
  readonly rules: readonly NoticeRuleShape[];
  readonly push: PushList;
}

@customElement("t-account-rules")
export class NotificationRules extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      /* What is changed takes the whole row. */
      li.open {
        grid-template-columns: minmax(0, 1fr);
        row-gap: var(--t-space-4);
      }
    `,
  ];

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly known = new LoadController<LoadedRules>(this);
  private readonly action = new ActionController(this);
  /** The id of the rule that is being changed; empty for a new one. */
  private readonly form = new OpenSubject<string>(this);
  private readonly tester = new TestMessageController(this, this.action, (id) => new NotifyApi(this.api).testRule(id));

  override willUpdate(): void {
    this.known.load("rules", async () => {
      const api = new NotifyApi(this.api);
      const [{ ways }, { rules }, push] = await Promise.all([api.channelChoices(), api.rules(), api.pushSubscriptions()]);
      return { ways, rules, push };
    });
  }

  override render(): TemplateResult {
    return html`<h2>${msg("Messages about alarms")}</h2>
      ${renderLoaded(this.known, msg("your rules"), (known) => this.renderContent(known))}
      ${this.isFormOpen(this.known.value) ? nothing : renderAdvice(this.action.problem)}`;
  }

  /** Whether a form is shown: it says by itself what went wrong. */
  private isFormOpen(known: LoadedRules | undefined): boolean {
    return this.form.subject === "" || known?.rules.some(({ id }) => id === this.form.subject) === true;
  }

  private renderContent(known: LoadedRules): TemplateResult {
    if (known.ways.length === 0) {
      return html`<p class="muted">${msg("No notification channels yet: an admin first sets up mail, a webhook, a chat or push messages under Admin, Notification.")}</p>`;
    }
    return html`${known.rules.length === 0
        ? html`<p class="muted">${msg("You get no notifications of alarms. They are still shown on every page.")}</p>`
        : renderRows(known.rules, (rule) => this.renderRule(rule, known))}
      ${this.form.subject === ""
        ? html`<h3>${msg("A new rule")}</h3>
            ${this.renderForm(null, known)}`
        : nothing}
      <div class="actions" ?hidden=${this.form.subject === ""}><t-button @click=${this.form.opener("")}>${msg("Notify me of alarms…")}</t-button></div>
      ${known.push.key === "" ? nothing : this.renderBrowsers(known.push)}`;
  }

  private renderRule(rule: NoticeRuleShape, known: LoadedRules): TemplateResult {
    const way = known.ways.find(({ id }) => id === rule.way);
    const name = rule.target === "" ? (way?.name ?? msg("a way that is gone")) : msg(str`${way?.name ?? msg("a way that is gone")} to ${rule.target ?? ""}`, { id: "to.recipient" });
    const site = rule.site === "*" ? msg("every site") : (this.sites.store?.siteRow(rule.site)?.name ?? rule.site);
    const quiet = quietHours(rule);
    const changed = rule.id === this.form.subject;
    return html`<li data-rule=${rule.id} class=${changed ? "open" : ""}>
      <div>
        <div class="name">${name}</div>
        <div class="facts">
          <span>${site}</span><span>${msg(html`${rule.least} and worse`)}</span>${rule.over === true ? html`<span>${msg("also when it is over")}</span>` : nothing}
          ${quiet === null ? nothing : html`<span>${msg(html`quiet ${quiet.from}–${quiet.to} (${rule.zone}) but for ${rule.quiet_least}`)}</span>`}
        </div>
        <t-went .went=${this.tester.lastResult(rule.id)}></t-went>
      </div>
      ${changed ? this.renderForm(rule, known) : nothing}
      <div class="actions" ?hidden=${changed}>
        <t-button label=${msg(str`Send a test: ${name}`)} ?busy=${this.tester.isRunning(rule.id)} @click=${this.tester.testAction(rule.id)}>${msg("Send a test")}</t-button>
        <t-button label=${msg(str`Change ${name}`)} @click=${this.form.opener(rule.id)}>${msg("Change…")}</t-button>
        <t-button label=${msg(str`Remove ${name}`)} @click=${this.ruleRemover(rule.id)}>${msg("Remove")}</t-button>
      </div>
    </li>`;
  }

  private renderForm(rule: NoticeRuleShape | null, known: LoadedRules): TemplateResult {
    return html`<t-rule-form
      .rule=${rule}
      .ways=${known.ways}
      .sites=${this.sites.store?.list ?? []}
      .problem=${this.action.problem}
      ?busy=${this.action.busy}
      @t-rule=${this.saveRule}
      @t-cancel=${this.closeForm}
    ></t-rule-form>`;
  }

  private renderBrowsers(push: PushList): TemplateResult {
    const why = whyNoPush();
    return html`<h3>${msg("Browsers that take push messages")}</h3>
      ${push.browsers.length === 0
        ? html`<p class="muted">${msg("None yet. A rule that uses push messages notifies all of them.")}</p>`
        : renderRows(
            push.browsers,
            (browser) => html`<li>
              <div>
                <div class="name">${browserName(browser.agent)}</div>
                <div class="facts"><span>${msg(html`since <t-time .us=${browser.created_us} .zone=${this.sites.store?.zone ?? "UTC"}></t-time>`)}</span></div>
              </div>
              <t-button label=${msg(str`Remove ${browserName(browser.agent)}`)} @click=${this.browserRemover(browser.id)}>${msg("Remove")}</t-button>
            </li>`,
          )}
      ${why === ""
        ? html`<div class="actions"><t-button ?busy=${this.action.runningKey === "push"} @click=${this.withdrawRule(push.key)}>${msg("Take messages in this browser")}</t-button></div>`
        : html`<p class="muted">${why}</p>`}`;
  }

  private readonly closeForm = (): void => {
    this.action.clear();
    this.form.close();
  };

  private readonly saveRule = (event: CustomEvent<RuleAsk>): void => {
    const id = this.form.subject ?? "";
    void this.action.run(msg("keep the rule"), () => new NotifyApi(this.api).saveRule(id, event.detail)).then((done) => {
      if (done) this.closeForm();
      this.known.invalidate();
    });
  };

  private ruleRemover(id: string): () => void {
    return () => {
      void this.action.run(msg("remove the rule"), () => new NotifyApi(this.api).removeRule(id)).then(this.known.invalidate);
    };
  }

  private browserRemover(id: string): () => void {
    return () => {
      void this.action.run(msg("remove the browser"), () => new NotifyApi(this.api).removeBrowser(id)).then(this.known.invalidate);
    };
  }

  private withdrawRule(key: string): () => void {
    return () => {
      void this.action
        .run(msg("take messages in this browser"), async () => new NotifyApi(this.api).addBrowser(await subscribePush(key)), "", "push")
        .then(this.known.invalidate);
    };
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-rules": NotificationRules;
  }
}
