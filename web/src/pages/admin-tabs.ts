/** The way between an admin's pages. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../elements/base/base-style.js";
import type { PageName } from "../state/router.js";

const TABS: readonly (readonly [PageName, string])[] = [
  ["people", msg("People")],
  ["roles", msg("Roles")],
  ["gateways", msg("Gateways")],
  ["clients", msg("Clients")],
  ["ways", msg("Notification")],
  ["storage", msg("Storage")],
  ["description", msg("Description")],
  ["audit", msg("Audit log")],
  ["support", msg("Support")],
];

@customElement("t-admin-tabs")
export class AdminTabs extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: block;
        min-inline-size: 0;
      }
      nav {
        display: flex;
        gap: var(--t-space-1);
        overflow-x: auto;
        border-block-end: 1px solid var(--t-line);
      }
      a {
        display: inline-flex;
        align-items: center;
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-3);
        border-block-end: 3px solid transparent;
        color: var(--t-muted);
        font-weight: var(--t-weight-strong);
        text-decoration: none;
        white-space: nowrap;
      }
      a:hover {
        color: var(--t-text);
      }
      a[aria-current] {
        border-block-end-color: var(--t-accent);
        color: var(--t-text);
      }
      a:focus-visible {
        outline-offset: -4px;
      }
      @media (max-width: 45rem) {
        nav {
          gap: 0;
        }
        a {
          padding-inline: var(--t-space-2);
        }
      }
    `,
  ];

  @property() page: PageName = "people";
  @query("nav") private readonly nav!: HTMLElement | null;
  @query("[aria-current]") private readonly open!: HTMLElement | null;

  /** On a phone the tabs are wider than the page: the one that is open is brought into view. */
  protected override firstUpdated(): void {
    const { nav, open } = this;
    if (nav === null || open === null) return;
    nav.scrollLeft = open.offsetLeft - nav.offsetLeft - (nav.clientWidth - open.offsetWidth) / 2;
  }

  override render(): TemplateResult {
    return html`<nav aria-label=${msg("Admin")}>
      ${map(
        TABS,
        ([page, title]) => html`<a href=${`/admin/${page}`} aria-current=${page === this.page ? "page" : nothing}
          >${title}</a
        >`,
      )}
    </nav>`;
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-admin-tabs": AdminTabs;
  }
}
