/** Sign in: name and password, and where to go afterwards. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { StoreController } from "../../controllers/store.js";
import { base } from "../../elements/base.js";
import { doorway } from "../../elements/doorway.js";
import { signInAdvice, type Advice } from "../../format/problem.js";
import { routerContext, sessionContext } from "../../state/contexts.js";
import { returnPath, type Router } from "../../state/router.js";
import "../../elements/button.js";
import "../../elements/field.js";
import "../../elements/problem.js";

@customElement("t-page-sign-in")
export class PageSignIn extends LitElement {
  static override styles = [
    base,
    doorway,
    css`
      .notice {
        color: var(--t-muted);
      }
    `,
  ];

  @state() private busy = false;
  @state() private advice: Advice | null = null;
  @state() private missing: "" | "name" | "password" = "";

  @query("#name") private readonly name!: HTMLInputElement;
  @query("#password") private readonly password!: HTMLInputElement;

  @consume({ context: routerContext }) private readonly router!: Router;
  private readonly session = new StoreController(this, sessionContext, (session) => {
    // Signed in already, here or in another tab.
    if (session.state === "known") this.router.replace(returnPath(this.router.search, this.router.origin));
  });

  override firstUpdated(): void {
    void this.begin();
  }

  override render(): TemplateResult {
    const notice = this.session.store?.notice ?? "";
    return html`
      <form novalidate @submit=${this.submit}>
        <div>
          <h1>Talaia</h1>
          <p class="muted">The control room for your robots</p>
        </div>
        ${notice === "" ? nothing : html`<p class="notice" role="status">You were signed out: ${notice}</p>`}
        ${this.advice === null
          ? nothing
          : html`<t-problem what=${this.advice.what} how=${this.advice.how}></t-problem>`}
        <t-field label="Name" error=${this.missing === "name" ? "Enter your name." : ""}>
          <input id="name" name="username" autocomplete="username" autocapitalize="none" spellcheck="false" required />
        </t-field>
        <t-field label="Password" error=${this.missing === "password" ? "Enter your password." : ""}>
          <input id="password" name="password" type="password" autocomplete="current-password" required />
        </t-field>
        <t-button type="submit" kind="primary" ?busy=${this.busy}>${this.busy ? "Signing in…" : "Sign in"}</t-button>
      </form>
    `;
  }

  private async begin(): Promise<void> {
    // A control takes the focus only once the field around it is drawn.
    await this.name.closest("t-field")?.updateComplete;
    this.name.focus();
  }

  private readonly submit = (event: SubmitEvent): void => {
    event.preventDefault();
    if (this.busy) return;
    const name = this.name.value.trim();
    const password = this.password.value;
    this.missing = name === "" ? "name" : password === "" ? "password" : "";
    if (this.missing === "name") this.name.focus();
    if (this.missing === "password") this.password.focus();
    if (this.missing === "") void this.signIn(name, password);
  };

  private async signIn(name: string, password: string): Promise<void> {
    this.busy = true;
    this.advice = null;
    try {
      await this.session.store?.login(name, password);
    } catch (error) {
      this.advice = signInAdvice(error);
      this.password.select();
    } finally {
      this.busy = false;
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-sign-in": PageSignIn;
  }
}
