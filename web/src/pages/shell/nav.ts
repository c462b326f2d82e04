/** The four places of the dashboard: beside the name on a desk, under the thumb on a phone. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base.js";
import type { IconName } from "../../elements/icons.js";
import { sitePath, type PageName } from "../../state/router.js";
import { PAGES } from "../routes.js";
import "../../elements/icon.js";

const PLACES: readonly { page: "home" | "live" | "history" | "drive"; icon: IconName }[] = [
  { page: "home", icon: "home" },
  { page: "live", icon: "live" },
  { page: "history", icon: "history" },
  { page: "drive", icon: "drive" },
];

@customElement("t-nav")
export class Nav extends LitElement {
  static override styles = [
    base,
    css`
      nav {
        display: flex;
        gap: var(--t-space-1);
      }
      a {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: 3.5rem;
        padding-inline: var(--t-space-3);
        border-block: 3px solid transparent;
        color: var(--t-muted);
        font-weight: var(--t-weight-strong);
        text-decoration: none;
        white-space: nowrap;
        touch-action: manipulation;
      }
      a:hover {
        color: var(--t-text);
      }
      a[aria-current] {
        border-block-end-color: var(--t-accent);
        color: var(--t-text);
      }
      a:not([href]) {
        opacity: 0.55;
        cursor: not-allowed;
      }
      a:focus-visible {
        outline-offset: -4px;
      }
      @media (max-width: 60rem) and (min-width: 45.01rem) {
        nav {
          gap: 0;
        }
        a {
          padding-inline: var(--t-space-2);
          font-size: var(--t-size-s);
        }
      }
      @media (max-width: 75rem) and (min-width: 45.01rem) {
        t-icon {
          display: none;
        }
      }
      @media (max-width: 60rem) and (min-width: 45.01rem) and (max-height: 30rem) {
        a {
          min-block-size: 3rem;
        }
      }
      @media (max-width: 45rem) {
        nav {
          gap: 0;
          padding-block-end: env(safe-area-inset-bottom);
          border-block-start: 1px solid var(--t-line);
          background: var(--t-surface);
        }
        a {
          flex: 1;
          flex-direction: column;
          justify-content: center;
          gap: 2px;
          padding-inline: 0;
          font-size: 0.75rem;
        }
        a[aria-current] {
          border-block-start-color: var(--t-accent);
          border-block-end-color: transparent;
          color: var(--t-accent);
        }
      }
    `,
  ];

  @property() page: PageName = "home";
  @property() site = "";

  override render(): TemplateResult {
    return html`<nav aria-label="Pages">
      ${map(
        PLACES,
        (place) => html`<a
          href=${this.pathOf(place.page) ?? nothing}
          aria-current=${place.page === this.page ? "page" : nothing}
          aria-disabled=${this.pathOf(place.page) === null ? "true" : nothing}
          ><t-icon name=${place.icon}></t-icon>${PAGES[place.page].title}</a
        >`,
      )}
    </nav>`;
  }

  /** Null when there is no site to go to. */
  private pathOf(page: "home" | "live" | "history" | "drive"): string | null {
    if (page === "home") return "/home";
    return this.site === "" ? null : sitePath(this.site, page);
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-nav": Nav;
  }
}
