/** Asks who it is: name and password, the second factor where there is one, a passkey, or the provider. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { TickerController } from "../../controllers/ticker.js";
import { isFactor, signInAdvice, isPasskey, waitOf, waitText, type Advice } from "../../format/error-advice.js";
import { LoadController } from "../../controllers/load.js";
import { apiContext, sessionContext } from "../../state/contexts.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import type { HubApi } from "../../wire/hub-api.js";
import { hasPasskeys } from "../../wire/passkeys.js";
import "../../elements/forms/button.js";
import "../../elements/forms/field.js";
import "../../elements/feedback/problem.js";

/** The session says who came in. */
@customElement("t-sign-in-form")
export class SignInForm extends LitElement {
  static override styles = [
    base,
    css`
      form {
        display: grid;
        gap: var(--t-space-4);
      }
      @media (max-height: 30rem) {
        form {
          gap: var(--t-space-2);
        }
      }
      t-button {
        margin-block-start: var(--t-space-2);
      }
      .notice {
        color: var(--t-muted);
      }
      .wait {
        font-weight: var(--t-weight-strong);
        font-variant-numeric: tabular-nums;
      }
      .who {
        display: grid;
        gap: inherit;
      }
      .who[hidden] {
        display: none;
      }
      t-button[kind="quiet"] {
        margin: 0;
      }
    `,
  ];

  /** Who is asked for; empty where anybody may come. */
  @property() who = "";
  /** The page that the provider leads back to. */
  @property() returns = "/home";
  /** Why the last session ended; empty when nobody needs to be told. */
  @property() notice = "";

  @state() private busy = false;
  @state() private advice: Advice | null = null;
  @state() private missing: "" | "name" | "password" | "code" = "";
  /** Name and password were right; the hub wants a code besides. */
  @state() private wantsCode = false;

  @query("#name") private readonly name!: HTMLInputElement;
  @query("#password") private readonly password!: HTMLInputElement;

  @query("#code") private readonly code!: HTMLInputElement | null;
  /** This page's clock (ms) when the hub may be asked again. */
  private waitUntil = 0;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly provider = new LoadController<string>(this);
  private readonly session = new ContextStoreController(this, sessionContext);

  constructor() {
    super();
    new TickerController(this);
  }

  override willUpdate(): void {
    this.provider.load("provider", () => this.api.provider());
  }

  override firstUpdated(): void {
    void this.focusFirst();
  }

  override render(): TemplateResult {
    const waits = this.waitS() > 0;
    return html`
      <form novalidate @submit=${this.onSubmit}>
        <slot></slot>
        ${this.wantsCode ? html`<p class="muted">${msg(str`One more step: ${this.name.value.trim()} has a second factor.`)}</p>` : nothing}
        ${this.notice === "" ? nothing : html`<p class="notice" role="status">${msg("You were signed out:")} ${this.notice}</p>`}
        ${this.renderProblem()}
        <div class="who" ?hidden=${this.wantsCode}>${this.renderCredentials()}</div>
        ${this.wantsCode ? this.renderCodeField() : nothing}
        <t-button type="submit" kind="primary" ?busy=${this.busy} ?disabled=${waits}
          >${this.busy ? msg("Signing in…") : msg("Sign in")}</t-button
        >
        ${hasPasskeys()
          ? html`<t-button ?disabled=${this.busy || waits} @click=${this.onPasskey}
              >${this.wantsCode ? msg("Use a passkey instead") : msg("Sign in with a passkey")}</t-button
            >`
          : nothing}
        ${this.wantsCode || (this.provider.value ?? "") === ""
          ? nothing
          : html`<t-button ?disabled=${this.busy} @click=${this.onProvider}>${msg(html`Sign in with ${this.provider.value}`)}</t-button>`}
        ${this.wantsCode ? html`<t-button kind="quiet" @click=${this.goBackToPassword}>${msg("Back to name and password")}</t-button>` : nothing}
      </form>
    `;
  }

  private renderProblem(): unknown {
    const { advice } = this;
    if (advice === null) return nothing;
    const wait = this.waitS();
    if (this.waitUntil > 0) {
      if (wait === 0) return html`<p class="notice" role="status">${msg("You can try again now.")}</p>`;
      // The alert is said once; the time that runs stands beside it in silence.
      return html`<t-problem what=${advice.what} how=${msg("The hub delays repeated tries.")}></t-problem>
        <p class="wait">${msg(str`Try again ${waitText(wait)}.`)}</p>`;
    }
    return renderAdvice(advice);
  }

  private renderCredentials(): TemplateResult {
    return html`
        <t-field label=${msg("Name")} error=${this.missing === "name" ? msg("Enter your name.") : ""}>
          <input id="name" name="username" autocomplete="username" autocapitalize="none" spellcheck="false" required .defaultValue=${this.who} />
        </t-field>
        <t-field label=${msg("Password")} error=${this.missing === "password" ? msg("Enter your password.") : ""}>
          <input id="password" name="password" type="password" autocomplete="current-password" required />
        </t-field>
    `;
  }

  private renderCodeField(): TemplateResult {
    return html`<t-field
      label=${msg("Code")}
      hint=${msg("Six digits from your app, or one of your recovery codes")}
      error=${this.missing === "code" ? msg("Enter the code.") : ""}
    >
      <input id="code" name="code" autocomplete="one-time-code" autocapitalize="none" spellcheck="false" required />
    </t-field>`;
  }

  private waitS(): number {
    return Math.max(0, Math.ceil((this.waitUntil - performance.now()) / 1000));
  }

  private async focusFirst(): Promise<void> {
    await this.updateComplete;
    const first = this.name.value === "" ? this.name : this.password;
    // A control takes the focus only once the field around it is drawn.
    await first.closest("t-field")?.updateComplete;
    first.focus();
  }

  private readonly onSubmit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.name.value.trim();
    const password = this.password.value;
    // Codes are often written with a space in the middle.
    const code = this.code?.value.replace(/\s+/g, "") ?? "";
    this.missing = name === "" ? "name" : password === "" ? "password" : this.wantsCode && code === "" ? "code" : "";
    if (this.missing === "name") this.name.focus();
    if (this.missing === "password") this.password.focus();
    if (this.missing === "code") this.code?.focus();
    if (this.missing === "" && this.waitS() === 0) void this.signIn(name, password, code);
  };

  private readonly onPasskey = (): void => {
    if (this.busy) return;
    const name = this.wantsCode ? this.name.value.trim() : "";
    const password = this.wantsCode ? this.password.value : "";
    void this.attempt(() => this.session.store?.loginByPasskey(name, password), true);
  };

  private readonly onProvider = (): void => {
    if (this.busy) return;
    void this.attempt(async () => {
      window.location.assign(await this.api.beginOidc("/api/login/oidc", this.returns));
    }, true);
  };

  private signIn(name: string, password: string, code: string): Promise<void> {
    return this.attempt(() => this.session.store?.login(name, password, code), code !== "");
  }

  private async attempt(signIn: () => Promise<void> | undefined, whole: boolean): Promise<void> {
    this.busy = true;
    this.advice = null;
    this.waitUntil = 0;
    try {
      await signIn();
    } catch (error) {
      await this.showFailure(error, whole);
    } finally {
      this.busy = false;
    }
  }

  private async showFailure(error: unknown, hadCode: boolean): Promise<void> {
    if (waitOf(error) > 0) this.waitUntil = performance.now() + waitOf(error) * 1000;
    const asked = isFactor(error);
    // That a code is wanted is no failure; that it did not fit is.
    this.advice = asked && !hadCode ? null : signInAdvice(error);
    // A passkey that did not answer leads nowhere else.
    this.wantsCode = (asked && this.name.value !== "") || (this.wantsCode && (waitOf(error) > 0 || isPasskey(error)));
    await this.updateComplete;
    const control = this.wantsCode ? this.code : this.password;
    await control?.closest("t-field")?.updateComplete;
    control?.focus();
    control?.select();
  }

  private readonly goBackToPassword = (): void => {
    this.wantsCode = false;
    this.advice = null;
    this.password.value = "";
    void this.focusFirst();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-sign-in-form": SignInForm;
  }
}
