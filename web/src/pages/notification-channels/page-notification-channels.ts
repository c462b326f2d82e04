/** The ways by which people can be told of alarms: mail, webhook, chat, push. Only admins set servers. */

import { consume } from "@lit/context";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { keyed } from "lit/directives/keyed.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { TestMessageController } from "../../controllers/test-message.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { forms } from "../../elements/forms/form-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import { formText } from "../../format/form-values.js";
import { apiContext } from "../../state/contexts.js";
import { NotifyApi, type ExtensionKeyShape, type ExtensionList, type ExtensionShape, type WayAsk, type WayShape } from "../../wire/alarms-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../../elements/feedback/confirm.js";
import "../../elements/feedback/empty.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/problem.js";
import "../../elements/feedback/status.js";
import "../../elements/feedback/delivery-result.js";
import "../admin-tabs.js";

type ChannelKind = WayAsk["kind"];

const KINDS: readonly { readonly kind: ChannelKind; readonly name: string }[] = [
  { kind: "mail", name: "E-mail (SMTP)" },
  { kind: "webhook", name: "Webhook" },
  { kind: "chat", name: "ntfy, Matrix or Telegram" },
  { kind: "push", name: "Push to browsers" },
  { kind: "extension", name: "An installed extension" },
];

@customElement("t-page-ways")
export class PageNotificationChannels extends LitElement {
  static override styles = [base, sheets, forms];

  /** Empty: a new one; null: none is being changed. */
  @state() private editing: string | null = null;
  @state() private kind: ChannelKind = "mail";
  @state() private notifier = "";
  @state() private removing: WayShape | null = null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly known = new LoadController<readonly WayShape[]>(this);
  private readonly installed = new LoadController<ExtensionList>(this);
  private readonly action = new ActionController(this);
  private readonly tester = new TestMessageController(this, this.action, (id) => new NotifyApi(this.api).testChannel(id));

  override willUpdate(): void {
    this.known.load("ways", async () => (await new NotifyApi(this.api).listChannels()).ways);
    this.installed.load("extensions", () => new NotifyApi(this.api).listExtensions());
  }

  override render(): TemplateResult {
    const { result, value } = this.known;
    const advice = result.state === "failed" ? adviceFor(result.error, "the ways") : null;
    return html`<t-admin-tabs page="ways"></t-admin-tabs>
      <div class="head">
        <div>
          <h1>Notification</h1>
          <p class="muted">The servers that send notifications of alarms. Each person then chooses among them on the account page.</p>
        </div>
        ${this.editing === null ? html`<t-button class="add" kind="primary" @click=${this.addChannel}>Add a channel</t-button>` : nothing}
      </div>
      ${renderAdvice(advice)}
      ${this.editing === null ? this.renderProblem() : nothing}
      ${this.editing === null
        ? nothing
        : // Another form for each: what is typed for one way, a password too, is for no other.
          keyed(this.editing, this.renderForm(value?.find(({ id }) => id === this.editing)))}
      ${value === undefined ? (advice === null ? html`<t-loading what="Loading the notification channels"></t-loading>` : nothing) : this.renderList(value)}
      ${map(this.installed.value?.broken ?? [], ({ group, name, problem }) => html`<t-problem what=${`The extension ${name} (${group}) is broken`} how=${problem}></t-problem>`)}
      <t-confirm
        ?open=${this.removing !== null}
        heading="Remove ${this.removing?.name ?? "this way"}?"
        action="Remove"
        ?busy=${this.action.busy}
        .problem=${this.action.problem}
        @t-confirm=${this.removeChannel}
        @t-close=${this.closeQuestion}
      >
        <p>It sends no more notifications; the rules that use it are removed, too.</p>
      </t-confirm>`;
  }

  private renderProblem(): TemplateResult | typeof nothing {
    const { problem } = this.action;
    // What is to be removed says it where it is asked.
    if (problem === null || this.removing !== null) return nothing;
    return html`<t-problem class="wide" what=${problem.what} how=${problem.how}></t-problem>`;
  }

  private renderList(ways: readonly WayShape[]): TemplateResult {
    if (ways.length === 0) {
      return html`<t-empty heading="No notification channels yet" icon="bell"><p>They are on every page all the same.</p></t-empty>`;
    }
    return html`<section class="sheet" aria-label="Notification channels">
      <ul class="rows">
        ${repeat(
          ways,
          ({ id }) => id,
          (way) => this.renderChannel(way),
        )}
      </ul>
    </section>`;
  }

  private renderChannel(way: WayShape): TemplateResult {
    const kind = KINDS.find((option) => option.kind === way.kind)?.name ?? way.kind;
    return html`<li data-way=${way.id}>
      <div>
        <div class="name">${way.name}</div>
        <div class="facts">
          <span>${kind}</span>${way.host === "" ? nothing : html`<span>${way.host}:${way.port}, ${way.security}</span>`}
          ${way.sender === "" ? nothing : html`<span>${way.sender}</span>`}
          ${way.secrets.length === 0 || way.kind === "push" ? nothing : html`<span>${way.secrets.join(", ")} kept, never shown</span>`}
        </div>
        <t-went .went=${this.tester.lastResult(way.id)}></t-went>
      </div>
      <div class="actions">
        <t-button label=${`Send a test: ${way.name}`} ?busy=${this.tester.isRunning(way.id)} @click=${this.tester.testAction(way.id)}>Send a test</t-button>
        <t-button class="change" label=${`Change ${way.name}`} @click=${this.editOpener(way)}>Change…</t-button>
        <t-button label=${`Remove ${way.name}`} @click=${this.removeAsker(way)}>Remove…</t-button>
      </div>
    </li>`;
  }

  private renderForm(way: WayShape | undefined): TemplateResult {
    return html`<section class="sheet" aria-labelledby="wish">
      <h2 id="wish">${way === undefined ? "New notification channel" : `Change ${way.name}`}</h2>
      <form class="entry" novalidate autocomplete="off" @submit=${this.onSubmit}>
        <t-field label="Name"><input name="name" maxlength="200" .value=${way?.name ?? ""} /></t-field>
        ${way === undefined
          ? html`<t-field label="Kind">
              <select name="kind" @change=${this.onKindChange}>
                ${map(KINDS, ({ kind, name }) => html`<option value=${kind} .selected=${kind === this.kind}>${name}</option>`)}
              </select>
            </t-field>`
          : nothing}
        ${this.renderFields(way)}
        <div class="actions">
          <t-button type="submit" kind="primary" ?busy=${this.action.busy}>${way === undefined ? "Add it" : "Save"}</t-button>
          <t-button @click=${this.closeForm}>Cancel</t-button>
        </div>
        ${this.renderProblem()}
      </form>
    </section>`;
  }

  private renderFields(way: WayShape | undefined): TemplateResult {
    const secretHint = (name: string): string => (way?.secrets.includes(name) === true ? "Kept; write only to change it" : "");
    const renderSecret = (name: string, label: string, hint: string): TemplateResult =>
      html`<t-field label=${label} hint=${secretHint(name) || hint}><input name=${name} type="password" autocomplete="new-password" maxlength="2000" /></t-field>`;
    switch (this.kind) {
      case "mail":
        return html`<t-field label="Server"><input name="host" maxlength="200" .value=${way?.host ?? ""} /></t-field>
          <t-field label="Port"><input name="port" inputmode="numeric" .value=${String(way?.port ?? 587)} /></t-field>
          <t-field label="Security" hint="A password goes only over TLS">
            <select name="security">
              ${map(["starttls", "tls", "none"], (word) => html`<option .selected=${word === (way?.security ?? "starttls")}>${word}</option>`)}
            </select>
          </t-field>
          <t-field label="Sender"><input name="sender" type="email" maxlength="200" .value=${way?.sender ?? ""} /></t-field>
          <t-field label="User"><input name="user" maxlength="200" .value=${way?.user ?? ""} /></t-field>
          ${renderSecret("password", "Password", "Kept sealed, and never shown again")}`;
      case "webhook":
        return html`${renderSecret("url", "Address", "https://…; kept sealed, and never shown again")}
        ${renderSecret("token", "Bearer token", "If the other side wants one")}`;
      case "chat":
        return html`${renderSecret("url", "Address", "ntfys://host/topic, matrixs://user:password@host/#room, tgram://token/chat")}`;
      case "push":
        return html`<t-field label="Mail address of an admin" hint="For the push services, if something is wrong">
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
    if (notifiers.length === 0) return html`<p class="muted">No notifier is installed beside this hub.</p>`;
    const name = way?.extension ?? (this.notifier || notifiers[0]?.name);
    const chosen = notifiers.find((notifier) => notifier.name === name);
    return html`${way === undefined
        ? html`<t-field label="Extension">
            <select name="extension" @change=${this.onNotifierChange}>
              ${map(notifiers, (notifier) => html`<option value=${notifier.name} .selected=${notifier.name === name}>${notifier.name}: ${notifier.summary}</option>`)}
            </select>
          </t-field>`
        : html`<input type="hidden" name="extension" .value=${way.extension} />
            <p class="muted">What is kept is never shown; write all of it to change it, or leave all of it empty.</p>`}
      ${map(
        chosen?.keys ?? [],
        (key) => html`<t-field label=${key.name} hint=${keyHint(key)}>
          <input name=${`key.${key.name}`} type=${key.secret ? "password" : "text"} autocomplete="off" maxlength="2000" />
        </t-field>`,
      )}`;
  }

  private readonly onNotifierChange = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.notifier = event.target.value;
  };

  private readonly addChannel = (): void => {
    this.openForm("", "mail");
  };

  private editOpener(way: WayShape): () => void {
    return () => {
      this.openForm(way.id, way.kind);
    };
  }

  private openForm(id: string, kind: ChannelKind): void {
    this.action.clear();
    this.kind = kind;
    this.editing = id;
    void focusInside(this, "form input");
  }

  /** Back to the button that opened the form. */
  private readonly closeForm = (): void => {
    const { editing } = this;
    this.action.clear();
    this.editing = null;
    void focusInside(this, editing === null || editing === "" ? ".add" : `li[data-way="${editing}"] .change`);
  };

  private readonly onKindChange = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.kind = event.target.value as ChannelKind;
  };

  private readonly onSubmit = (event: Event): void => {
    event.preventDefault();
    if (this.editing === null || !(event.currentTarget instanceof HTMLFormElement)) return;
    const data = new FormData(event.currentTarget);
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
    const id = this.editing;
    void this.action.run("keep the way", () => new NotifyApi(this.api).saveChannel(id, way)).then((done) => {
      if (done) this.closeForm();
      this.known.invalidate();
    });
  };

  private removeAsker(way: WayShape): () => void {
    return () => {
      this.action.clear();
      this.removing = way;
    };
  }

  private readonly closeQuestion = (): void => {
    this.removing = null;
  };

  private readonly removeChannel = (): void => {
    const way = this.removing;
    if (way === null) return;
    void this.action.run("remove the way", () => new NotifyApi(this.api).removeChannel(way.id)).then((done) => {
      if (done) this.removing = null;
      this.known.invalidate();
    });
  };
}

/** What a key may be and what it means, for whoever writes it. */
function keyHint(key: ExtensionKeyShape): string {
  const must = key.required ? "required" : key.default === "" ? "may be left out" : `${key.default} if left out`;
  return `${key.about === "" ? "" : `${key.about} `}(${key.type}, ${must})`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-ways": PageNotificationChannels;
  }
}
