/** The ways by which people can be told of alarms: mail, webhook, chat, push. Only admins set servers. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { keyed } from "lit/directives/keyed.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { QuestionController } from "../../controllers/question.js";
import { TestMessageController } from "../../controllers/test-message.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import { renderFormActions, renderOptions } from "../../elements/forms/form-parts.js";
import { forms } from "../../elements/forms/form-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { renderRowSheet } from "../../elements/layout/rows.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formText, submittedForm } from "../../format/form-values.js";
import { apiContext } from "../../state/contexts.js";
import { NotifyApi } from "../../wire/alarms-api.js";
import type { ExtensionKeyShape, ExtensionList, ExtensionShape, WayAsk, WayShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/feedback/delivery-result.js";
import "../admin-tabs.js";

type ChannelKind = WayAsk["kind"];

const KINDS: readonly { readonly kind: ChannelKind; readonly name: string }[] = [
  { kind: "mail", name: msg("E-mail (SMTP)") },
  { kind: "webhook", name: msg("Webhook") },
  { kind: "chat", name: msg("ntfy, Matrix or Telegram") },
  { kind: "push", name: msg("Push to browsers") },
  { kind: "extension", name: msg("An installed extension") },
];

@customElement("t-page-ways")
export class PageNotificationChannels extends LitElement {
  static override styles = [base, sheets, forms];

  @state() private kind: ChannelKind = "mail";
  @state() private notifier = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly known = new LoadController<readonly WayShape[]>(this);
  private readonly installed = new LoadController<ExtensionList>(this);
  private readonly action = new ActionController(this);
  /** The id of the channel that is being changed; empty for a new one. */
  private readonly form = new OpenSubject<string>(this);
  private readonly removing = new QuestionController<WayShape>(this, (way, action) =>
    action.run(msg("remove the way"), () => new NotifyApi(this.api).removeChannel(way.id)).finally(this.known.invalidate),
  );
  private readonly tester = new TestMessageController(this, this.action, (id) => new NotifyApi(this.api).testChannel(id));

  override willUpdate(): void {
    this.known.load("ways", async () => (await new NotifyApi(this.api).listChannels()).ways);
    this.installed.load("extensions", () => new NotifyApi(this.api).listExtensions());
  }

  override render(): TemplateResult {
    const editing = this.form.subject;
    return html`<t-admin-tabs page="ways"></t-admin-tabs>
      ${renderPageHead(
        msg("Notification"),
        msg("The servers that send notifications of alarms. Each person then chooses among them on the account page."),
        html`<t-button kind="primary" ?hidden=${this.form.isOpen} @click=${this.addChannel}>${msg("Add a channel")}</t-button>`,
      )}
      ${editing === null
        ? renderAdvice(this.action.problem)
        : // Another form for each: what is typed for one way, a password too, is for no other.
          keyed(editing, this.renderForm(this.known.value?.find(({ id }) => id === editing)))}
      ${renderLoaded(this.known, msg("the notification channels"), (ways) => this.renderList(ways))}
      ${map(this.installed.value?.broken ?? [], ({ group, name, problem }) => html`<t-problem what=${msg(str`The extension ${name} (${group}) is broken`)} how=${problem}></t-problem>`)}
      ${renderQuestion(this.removing, ({ name }) => ({
        heading: msg(str`Remove ${name}?`),
        action: msg("Remove"),
        text: msg("It sends no more notifications; the rules that use it are removed, too."),
      }))}`;
  }

  private renderList(ways: readonly WayShape[]): TemplateResult {
    if (ways.length === 0) {
      return html`<t-empty heading=${msg("No notification channels yet")} icon="bell"><p>${msg("They are on every page all the same.")}</p></t-empty>`;
    }
    return renderRowSheet(msg("Notification channels"), ways, (way) => this.renderChannel(way));
  }

  private renderChannel(way: WayShape): TemplateResult {
    const kind = KINDS.find((option) => option.kind === way.kind)?.name ?? way.kind;
    return html`<li data-way=${way.id}>
      <div>
        <div class="name">${way.name}</div>
        <div class="facts">
          <span>${kind}</span>${way.host === "" ? nothing : html`<span>${way.host}:${way.port}, ${way.security}</span>`}
          ${way.sender === "" ? nothing : html`<span>${way.sender}</span>`}
          ${way.secrets.length === 0 || way.kind === "push" ? nothing : html`<span>${msg(str`${way.secrets.join(", ")} kept, never shown`)}</span>`}
        </div>
        <t-went .went=${this.tester.lastResult(way.id)}></t-went>
      </div>
      <div class="actions">
        <t-button label=${msg(str`Send a test: ${way.name}`)} ?busy=${this.tester.isRunning(way.id)} @click=${this.tester.testAction(way.id)}>${msg("Send a test")}</t-button>
        <t-button label=${msg(str`Change ${way.name}`)} @click=${this.editOpener(way)}>${msg("Change…")}</t-button>
        <t-button label=${msg(str`Remove ${way.name}`)} @click=${this.removing.opener(way)}>${msg("Remove…")}</t-button>
      </div>
    </li>`;
  }

  private renderForm(way: WayShape | undefined): TemplateResult {
    return html`<section class="sheet" aria-labelledby="wish">
      <h2 id="wish">${way === undefined ? msg("New notification channel") : msg(str`Change ${way.name}`)}</h2>
      <form class="entry" novalidate autocomplete="off" @submit=${this.onSubmit}>
        <t-field label=${msg("Name")}><input name="name" maxlength="200" .value=${way?.name ?? ""} /></t-field>
        ${way === undefined
          ? html`<t-field label=${msg("Kind")}>
              <select name="kind" @change=${this.onKindChange}>
                ${renderOptions(KINDS.map(({ kind, name }) => [kind, name]), this.kind)}
              </select>
            </t-field>`
          : nothing}
        ${this.renderFields(way)}
        ${renderFormActions({ submit: way === undefined ? msg("Add it") : msg("Save"), busy: this.action.busy, cancel: this.closeForm })}
        ${renderAdvice(this.action.problem)}
      </form>
    </section>`;
  }

  private renderFields(way: WayShape | undefined): TemplateResult {
    const secretHint = (name: string): string => (way?.secrets.includes(name) === true ? msg("Kept; write only to change it") : "");
    const renderSecret = (name: string, label: string, hint: string): TemplateResult =>
      html`<t-field label=${label} hint=${secretHint(name) || hint}><input name=${name} type="password" autocomplete="new-password" maxlength="2000" /></t-field>`;
    switch (this.kind) {
      case "mail":
        return html`<t-field label=${msg("Server")}><input name="host" maxlength="200" .value=${way?.host ?? ""} /></t-field>
          <t-field label=${msg("Port")}><input name="port" inputmode="numeric" .value=${String(way?.port ?? 587)} /></t-field>
          <t-field label=${msg("Security")} hint=${msg("A password goes only over TLS")}>
            <select name="security">${renderOptions(["starttls", "tls", "none"], way?.security ?? "starttls")}</select>
          </t-field>
          <t-field label=${msg("Sender")}><input name="sender" type="email" maxlength="200" .value=${way?.sender ?? ""} /></t-field>
          <t-field label=${msg("User")}><input name="user" maxlength="200" .value=${way?.user ?? ""} /></t-field>
          ${renderSecret("password", msg("Password"), msg("Kept sealed, and never shown again"))}`;
      case "webhook":
        return html`${renderSecret("url", msg("Address"), msg("https://…; kept sealed, and never shown again"))}
        ${renderSecret("token", msg("Bearer token"), msg("If the other side wants one"))}`;
      case "chat":
        return html`${renderSecret("url", msg("Address"), msg("ntfys://host/topic, matrixs://user:password@host/#room, tgram://token/chat"))}`;
      case "push":
        return html`<t-field label=${msg("Mail address of an admin")} hint=${msg("For the push services, if something is wrong")}>
          <input name="sender" type="email" maxlength="200" .value=${way?.sender ?? ""} />
        </t-field>`;
      case "extension":
        return this.renderNotifier(way);
    }
  }

  private get notifiers(): readonly ExtensionShape[] {
    return this.installed.value?.extensions.filter(({ group }) => group === "talaia.notifiers") ?? [];
  }

  /** The keys of an installed notifier; they are kept sealed, all at once. */
  private renderNotifier(way: WayShape | undefined): TemplateResult {
    const { notifiers } = this;
    if (notifiers.length === 0) return html`<p class="muted">${msg("No notifier is installed beside this hub.")}</p>`;
    const name = way?.extension ?? (this.notifier || notifiers[0]?.name);
    const chosen = notifiers.find((notifier) => notifier.name === name);
    return html`${way === undefined
        ? html`<t-field label=${msg("Extension")}>
            <select name="extension" @change=${this.onNotifierChange}>
              ${renderOptions(notifiers.map((notifier) => [notifier.name, `${notifier.name}: ${notifier.summary}`]), name ?? "")}
            </select>
          </t-field>`
        : html`<input type="hidden" name="extension" .value=${way.extension} />
            <p class="muted">${msg("What is kept is never shown; write all of it to change it, or leave all of it empty.")}</p>`}
      ${map(
        chosen?.keys ?? [],
        (key) => html`<t-field label=${key.name} hint=${keyHint(key)}>
          <input name=${msg(str`key.${key.name}`)} type=${key.secret ? "password" : "text"} autocomplete="off" maxlength="2000" />
        </t-field>`,
      )}`;
  }

  private readonly onNotifierChange = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.notifier = event.target.value;
  };

  private readonly addChannel = (event: Event): void => {
    this.openForm("", "mail", event);
  };

  private editOpener(way: WayShape): (event: Event) => void {
    return (event) => {
      this.openForm(way.id, way.kind, event);
    };
  }

  private openForm(id: string, kind: ChannelKind, event: Event): void {
    this.action.clear();
    this.kind = kind;
    this.form.opener(id)(event);
    void focusInside(this, "form input");
  }

  private readonly closeForm = (): void => {
    this.action.clear();
    this.form.close();
  };

  private readonly onKindChange = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.kind = event.target.value as ChannelKind;
  };

  private readonly onSubmit = (event: Event): void => {
    const data = submittedForm(event);
    const id = this.form.subject;
    if (id === null || data === undefined) return;
    const text = (name: string): string => formText(data, name);
    const secrets: Record<string, string> = {};
    for (const key of ["password", "url", "token"]) if (text(key) !== "") secrets[key] = text(key);
    const entries = this.kind === "extension" ? [...data.keys()].filter((name) => name.startsWith("key.") && text(name) !== "") : [];
    const keys = Object.fromEntries(entries.map((name) => [name.slice(4), text(name)]));
    const security = text("security");
    const way: WayAsk = {
      name: text("name"), kind: this.kind, host: text("host"), port: Number(text("port")) || 587,
      security: security === "tls" || security === "none" ? security : "starttls", sender: text("sender"), user: text("user"),
      ...(this.kind === "extension" ? { extension: text("extension") } : {}),
      secrets: entries.length === 0 ? secrets : { ...secrets, keys },
    };
    void this.action.run(msg("keep the way"), () => new NotifyApi(this.api).saveChannel(id, way)).then((done) => {
      if (done) this.closeForm();
      this.known.invalidate();
    });
  };
}

/** What a key may be and what it means, for whoever writes it. */
function keyHint(key: ExtensionKeyShape): string {
  const must = key.required ? msg("required") : key.default === "" ? msg("may be left out") : msg(str`${key.default} if left out`);
  return `${key.about === "" ? "" : `${key.about} `}(${key.type}, ${must})`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-ways": PageNotificationChannels;
  }
}
