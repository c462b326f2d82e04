/** Set up or remove the codes of an app, as one's second factor. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { css, html, LitElement, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { focusInside } from "../../elements/base/focus.js";
import { renderFormActions } from "../../elements/forms/form-parts.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, sessionContext } from "../../state/contexts.js";
import type { Session } from "../../state/session.js";
import { AccountApi } from "../../wire/account-api.js";
import type { FactorOffer } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import { renderRecoveryCodes } from "./recovery-codes.js";
import "../../elements/forms/copy-text.js";
import "../../elements/forms/field.js";
import "../../elements/values/qr-code.js";
import "../../elements/feedback/status.js";

/** Where one stands: at rest, about to begin, scanning, looking at the recovery codes, about to remove it. */
type SetupStep = "rest" | "begin" | "scan" | "codes" | "remove";

/** @fires t-changed it was set up or removed */
@customElement("t-account-factor")
export class SecondFactor extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .scan {
        display: flex;
        flex-wrap: wrap;
        gap: var(--t-space-4);
      }
      .scan > div {
        flex: 1 1 14rem;
        display: grid;
        align-content: start;
        gap: var(--t-space-3);
        min-inline-size: 0;
      }
    `,
  ];

  /** There is one now. */
  @property({ type: Boolean }) active = false;
  @state() private step: SetupStep = "rest";
  @state() private offer: FactorOffer | null = null;
  @state() private recovery: readonly string[] = [];
  @query("#password") private readonly password!: HTMLInputElement | null;
  @query("#code") private readonly code!: HTMLInputElement | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  @consume({ context: sessionContext }) private readonly session!: Session;
  private readonly action = new ActionController(this);

  override render(): TemplateResult {
    const { problem } = this.action;
    const on = this.active || this.step === "codes";
    return html`<div class="head">
        <h2>${msg("Codes from an app")}</h2>
        <t-status kind=${on ? "ok" : "unknown"} word=${on ? msg("on") : msg("off")}></t-status>
      </div>
      ${renderAdvice(problem)}
      ${this.renderContent()}`;
  }

  private renderContent(): TemplateResult {
    switch (this.step) {
      case "rest":
        return this.renderIdle();
      case "begin":
        return this.renderForm(msg("Continue"), this.requestSetup, this.renderPasswordField());
      case "scan":
        return this.renderScan();
      case "codes":
        return renderRecoveryCodes(this.recovery, this.onKept);
      case "remove":
        return this.renderForm(
          msg("Remove it"),
          this.removeFactor,
          html`${this.renderPasswordField()}${this.renderCodeField(msg("Six digits from your app, or a recovery code"))}`,
        );
    }
  }

  private renderIdle(): TemplateResult {
    return this.active
      ? html`<p>${msg("A code from your app is asked for at each sign-in.")}</p>
          <div class="actions"><t-button @click=${this.stepOpener("remove")}>${msg("Remove it…")}</t-button></div>`
      : html`<p>
            ${msg("With one, a password alone lets nobody in: an app on your phone shows a code that changes every 30 s.")}
          </p>
          <div class="actions"><t-button kind="primary" @click=${this.stepOpener("begin")}>${msg("Set it up")}</t-button></div>`;
  }

  private renderScan(): TemplateResult {
    const { offer } = this;
    if (offer === null) return this.renderIdle();
    return html`<div class="scan">
      <t-qr .svg=${offer.qr} label=${msg("QR code that holds the secret beside it")}></t-qr>
      <div>
        <p>${msg("Scan this with your app, or type the secret into it. Then enter the code that it shows.")}</p>
        <t-copy label=${msg("Secret")} .text=${offer.secret}></t-copy>
      </div>
    </div>
    ${this.renderForm(msg("Switch it on"), this.onConfirm, this.renderCodeField(msg("Six digits from your app")))}`;
  }

  private renderForm(words: string, submit: () => Promise<void>, fields: TemplateResult): TemplateResult {
    const onSubmit = (event: SubmitEvent): void => {
      event.preventDefault();
      void submit();
    };
    return html`<form class="fields" novalidate @submit=${onSubmit}>
      ${fields} ${renderFormActions({ submit: words, busy: this.action.busy, cancel: this.stepOpener("rest") })}
    </form>`;
  }

  private renderPasswordField(): TemplateResult {
    return html`<t-field label=${msg("Your password")} hint=${msg("So that it is you who changes this.")}>
      <input id="password" type="password" autocomplete="current-password" required />
    </t-field>`;
  }

  private renderCodeField(hint: string): TemplateResult {
    return html`<t-field label=${msg("Code")} hint=${hint}>
      <input id="code" autocomplete="one-time-code" autocapitalize="none" spellcheck="false" required />
    </t-field>`;
  }

  private stepOpener(step: SetupStep): () => void {
    return () => {
      this.showStep(step);
    };
  }

  private showStep(step: SetupStep): void {
    this.step = step;
    this.action.clear();
    if (step === "rest") {
      this.offer = null;
      this.recovery = [];
    }
    // At rest the focus goes to the button that begins anew.
    void focusInside(this, step === "rest" ? ".actions t-button" : "input");
  }

  private readonly requestSetup = async (): Promise<void> => {
    const password = this.password?.value ?? "";
    const done = await this.action.run(msg("begin the set-up"), async () => {
      this.offer = await new AccountApi(this.api).offerFactor(password);
    });
    if (done) this.showStep("scan");
  };

  private readonly onConfirm = async (): Promise<void> => {
    const code = this.typedCode();
    const done = await this.action.run(msg("switch it on"), async () => {
      this.recovery = await new AccountApi(this.api).confirmFactor(code);
    });
    if (!done) return;
    this.offer = null;
    this.showStep("codes");
    this.dispatchEvent(new CustomEvent("t-changed"));
  };

  /** Only now: who had to set it up is led on to another page. */
  private readonly onKept = (): void => {
    this.showStep("rest");
    void this.session.refresh().catch(() => undefined);
  };

  private readonly removeFactor = async (): Promise<void> => {
    const password = this.password?.value ?? "";
    const code = this.typedCode();
    if (!(await this.action.run(msg("remove it"), () => new AccountApi(this.api).removeFactor(password, code)))) return;
    this.showStep("rest");
    this.dispatchEvent(new CustomEvent("t-changed"));
    await this.session.refresh().catch(() => undefined);
  };

  private typedCode(): string {
    return this.code?.value.replace(/\s+/g, "") ?? "";
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-account-factor": SecondFactor;
  }
}
