/** The frame around every page: header, navigation, and the place where the page stands. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { StoreController } from "../../controllers/store.js";
import { base } from "../../elements/base.js";
import { routerContext, sessionContext } from "../../state/contexts.js";
import { PAGES } from "../routes.js";

@customElement("t-shell")
export class Shell extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
      }
    `,
  ];

  /** The hub did not answer when it was last asked. */
  @property({ type: Boolean }) unreachable = false;

  @state() private page: HTMLElement | null = null;

  private shown = "";
  private readonly router = new StoreController(this, routerContext);
  private readonly session = new StoreController(this, sessionContext);

  override willUpdate(): void {
    void this.show();
  }

  override render(): TemplateResult {
    return html`<main id="main" tabindex="-1">${this.page ?? nothing}</main>`;
  }

  private async show(): Promise<void> {
    const route = this.router.store?.route;
    if (route === undefined || this.session.store?.state === "unknown") return;
    const key = `${route.page} ${route.site}`;
    if (key === this.shown) return;
    this.shown = key;
    const entry = PAGES[route.page];
    await entry.load();
    if (this.shown !== key) return;
    const page = document.createElement(entry.tag);
    if ("site" in page) page.site = route.site;
    this.page = page;
    document.title = `${entry.title} · Talaia`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-shell": Shell;
  }
}
