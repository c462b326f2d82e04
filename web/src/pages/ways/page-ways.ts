/** The ways by which people can be told of alarms: mail, webhook, chat, push. Only admins set servers. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { base } from "../../elements/base.js";
import { sheets } from "../../elements/sheets.js";
import { adviceFor } from "../../format/problem.js";
import { apiContext } from "../../state/contexts.js";
import { NotifyApi, type WayAsk, type WayShape, type WentShape } from "../../wire/alarms.js";
import type { HubApi } from "../../wire/http.js";
import "../../elements/button.js";
import "../../elements/confirm.js";
import "../../elements/empty.js";
import "../../elements/field.js";
import "../../elements/loading.js";
import "../../elements/problem.js";
import "../../elements/status.js";
import "../admin-tabs.js";

type Kind = WayAsk["kind"];

const KINDS: readonly { readonly kind: Kind; readonly name: string }[] = [
  { kind: "mail", name: "E-mail (SMTP)" },
  { kind: "webhook", name: "Webhook" },
  { kind: "chat", name: "ntfy, Matrix or Telegram" },
  { kind: "push", name: "Push to browsers" },
];

@customElement("t-page-ways")
export class PageWays extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      form {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(16rem, 100%), 1fr));
        align-items: start;
        gap: var(--t-space-3);
      }
      .went {
        overflow-wrap: anywhere;
      }
    `,
  ];

  /** Empty: a new one; null: none is being changed. */
  @state() private editing: string | null = null;
  @state() private kind: Kind = "mail";
  @state() private removing: WayShape | null = null;
  @state() private went: { readonly id: string; readonly how: WentShape } | null = null;
  @query("form") private readonly form!: HTMLFormElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly known = new LoadController<readonly WayShape[]>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.known.ask("ways", async () => (await new NotifyApi(this.api).ways()).ways);
  }

  override render(): TemplateResult {
    const { result, value } = this.known;
    const advice = result.state === "failed" ? adviceFor(result.error, "the ways") : null;
    return html`<t-admin-tabs page="ways"></t-admin-tabs>
      <div class="head">
        <div>
          <h1>Notification</h1>
          <p class="muted">The servers by which people are told of alarms. Each person then chooses on the account page.</p>
        </div>
        ${this.editing === null ? html`<t-button kind="primary" @click=${this.add}>Add a way</t-button>` : nothing}
      </div>
      ${advice === null ? nothing : html`<t-problem what=${advice.what} how=${advice.how}></t-problem>`}
      ${this.action.problem === null
        ? nothing
        : html`<t-problem what=${this.action.problem.what} how=${this.action.problem.how}></t-problem>`}
      ${this.editing === null ? nothing : this.wish(value?.find(({ id }) => id === this.editing))}
      ${value === undefined ? (advice === null ? html`<t-loading what="Loading the ways"></t-loading>` : nothing) : this.list(value)}
      <t-confirm
        ?open=${this.removing !== null}
        heading="Remove ${this.removing?.name ?? "this way"}?"
        action="Remove"
        ?busy=${this.action.busy}
        .problem=${this.action.problem}
        @t-confirm=${this.erase}
        @t-close=${this.unask}
      >
        <p>Nobody is told by it any more; the rules that use it go, too.</p>
      </t-confirm>`;
  }

  private list(ways: readonly WayShape[]): TemplateResult {
    if (ways.length === 0) {
      return html`<t-empty heading="Nobody is told of alarms yet" icon="bell"><p>They are on every page all the same.</p></t-empty>`;
    }
    return html`<section class="sheet" aria-label="Ways">
      <ul class="rows">
        ${repeat(
          ways,
          ({ id }) => id,
          (way) => this.way(way),
        )}
      </ul>
    </section>`;
  }

  private way(way: WayShape): TemplateResult {
    const kind = KINDS.find((one) => one.kind === way.kind)?.name ?? way.kind;
    return html`<li>
      <div>
        <div class="name">${way.name}</div>
        <div class="facts">
          <span>${kind}</span>${way.host === "" ? nothing : html`<span>${way.host}:${way.port}, ${way.security}</span>`}
          ${way.sender === "" ? nothing : html`<span>${way.sender}</span>`}
          ${way.secrets.length === 0 || way.kind === "push" ? nothing : html`<span>${way.secrets.join(", ")} kept, never shown</span>`}
        </div>
        ${this.went?.id === way.id
          ? html`<div class="went" role="status">
              ${this.went.how.sent ? html`<t-status kind="ok" word="the test was taken"></t-status>` : html`<t-status kind="bad" word="not sent"></t-status> ${this.went.how.problem}`}
            </div>`
          : nothing}
      </div>
      <div class="actions">
        <t-button ?busy=${this.action.under === `test ${way.id}`} @click=${this.tester(way.id)}>Send a test</t-button>
        <t-button @click=${this.changer(way)}>Change</t-button>
        <t-button @click=${this.asker(way)}>Remove</t-button>
      </div>
    </li>`;
  }

  private wish(way: WayShape | undefined): TemplateResult {
    return html`<section class="sheet" aria-label=${way === undefined ? "A new way" : `Change ${way.name}`}>
      <form novalidate autocomplete="off" @submit=${this.submitted}>
        <t-field label="Name"><input name="name" maxlength="200" .value=${way?.name ?? ""} /></t-field>
        ${way === undefined
          ? html`<t-field label="Kind">
              <select name="kind" @change=${this.choose}>
                ${map(KINDS, ({ kind, name }) => html`<option value=${kind} ?selected=${kind === this.kind}>${name}</option>`)}
              </select>
            </t-field>`
          : nothing}
        ${this.fields(way)}
      </form>
      <div class="actions">
        <t-button kind="primary" ?busy=${this.action.busy} @click=${this.submitted}>Keep</t-button>
        <t-button @click=${this.cancel}>Cancel</t-button>
      </div>
    </section>`;
  }

  private fields(way: WayShape | undefined): TemplateResult {
    const kept = (name: string): string => (way?.secrets.includes(name) === true ? "Kept; write only to change it" : "");
    const secret = (name: string, label: string, hint: string): TemplateResult =>
      html`<t-field label=${label} hint=${kept(name) || hint}><input name=${name} type="password" autocomplete="new-password" maxlength="2000" /></t-field>`;
    switch (this.kind) {
      case "mail":
        return html`<t-field label="Server"><input name="host" maxlength="200" .value=${way?.host ?? ""} /></t-field>
          <t-field label="Port"><input name="port" inputmode="numeric" .value=${String(way?.port ?? 587)} /></t-field>
          <t-field label="Security" hint="A password goes only over TLS">
            <select name="security">
              ${map(["starttls", "tls", "none"], (word) => html`<option ?selected=${word === (way?.security ?? "starttls")}>${word}</option>`)}
            </select>
          </t-field>
          <t-field label="Sender"><input name="sender" type="email" maxlength="200" .value=${way?.sender ?? ""} /></t-field>
          <t-field label="User"><input name="user" maxlength="200" .value=${way?.user ?? ""} /></t-field>
          ${secret("password", "Password", "Kept sealed, and never shown again")}`;
      case "webhook":
        return html`${secret("url", "Address", "https://…; kept sealed, and never shown again")}
        ${secret("token", "Bearer token", "If the other side wants one")}`;
      case "chat":
        return html`${secret("url", "Address", "ntfys://host/topic, matrixs://user:password@host/#room, tgram://token/chat")}`;
      case "push":
        return html`<t-field label="Mail address of an admin" hint="For the push services, if something is wrong">
          <input name="sender" type="email" maxlength="200" .value=${way?.sender ?? ""} />
        </t-field>`;
    }
  }

  private readonly add = (): void => {
    this.action.clear();
    this.kind = "mail";
    this.editing = "";
  };

  private changer(way: WayShape): () => void {
    return () => {
      this.action.clear();
      this.kind = way.kind;
      this.editing = way.id;
    };
  }

  private readonly cancel = (): void => {
    this.editing = null;
  };

  private readonly choose = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.kind = event.target.value as Kind;
  };

  private readonly submitted = (event: Event): void => {
    event.preventDefault();
    if (this.form === null || this.editing === null) return;
    const data = new FormData(this.form);
    const text = (key: string): string => {
      const value = data.get(key);
      return typeof value === "string" ? value.trim() : "";
    };
    const secrets: Record<string, string> = {};
    for (const key of ["password", "url", "token"]) if (text(key) !== "") secrets[key] = text(key);
    const security = text("security");
    const way: WayAsk = {
      name: text("name"), kind: this.kind, host: text("host"), port: Number(text("port")) || 587,
      security: security === "tls" || security === "none" ? security : "starttls", sender: text("sender"), user: text("user"), secrets,
    };
    const id = this.editing;
    void this.action.run("keep the way", () => new NotifyApi(this.api).putWay(id, way)).then((done) => {
      if (done) this.editing = null;
      this.known.again();
    });
  };

  private tester(id: string): () => void {
    return () => {
      this.went = null;
      void this.action.run(
        "send the test",
        async () => {
          this.went = { id, how: await new NotifyApi(this.api).testWay(id) };
        },
        "",
        `test ${id}`,
      );
    };
  }

  private asker(way: WayShape): () => void {
    return () => {
      this.action.clear();
      this.removing = way;
    };
  }

  private readonly unask = (): void => {
    this.removing = null;
  };

  private readonly erase = (): void => {
    const way = this.removing;
    if (way === null) return;
    void this.action.run("remove the way", () => new NotifyApi(this.api).removeWay(way.id)).then((done) => {
      if (done) this.removing = null;
      this.known.again();
    });
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-ways": PageWays;
  }
}
