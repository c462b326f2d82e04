/** The places of the dashboard that a person may open: beside the name on a desk, under the thumb on a phone. */

import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import type { IconName } from "../../elements/base/icons.js";
import { seesOnlyPublic } from "../../state/rights.js";
import { ADMIN_PAGES, sitePath, type PageName } from "../../state/router.js";
import type { Me } from "../../generated/api.js";
import { mayOpen, PAGES } from "../routes.js";
import "../../elements/base/icon.js";

interface NavigationPlace {
  readonly page: "home" | "public" | "devices" | "live" | "history" | "alarms" | "drive" | "archive" | "night" | "people";
  readonly icon: IconName;
  readonly title?: string;
}

const PLACES: readonly NavigationPlace[] = [
  { page: "home", icon: "home" },
  { page: "public", icon: "open" },
  { page: "devices", icon: "devices" },
  { page: "live", icon: "live" },
  { page: "history", icon: "history" },
  { page: "alarms", icon: "bell" },
  { page: "drive", icon: "drive" },
  { page: "night", icon: "moon" },
  { page: "archive", icon: "camera" },
  { page: "people", icon: "shield", title: "Admin" },
];

/** So many places leave no room for their icons beside a site's name. */
const FULL = 8;

@customElement("t-nav")
export class Navigation extends LitElement {
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
      @media (max-width: 96rem) and (min-width: 45.01rem) {
        nav {
          gap: 0;
        }
        a {
          padding-inline: var(--t-space-2);
        }
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
      /* With all of them the site's name would have no room. */
      @media (max-width: 96rem) and (min-width: 45.01rem) {
        .full t-icon {
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
          min-inline-size: 0;
          padding-inline: 0;
          font-size: 0.75rem;
        }
        /* An admin's work is done at a desk; on a phone the menu of one's name leads there. */
        .people {
          display: none;
        }
        /* Seven of them stand side by side: the longest word is as wide as its seventh. */
        .night-here a {
          font-size: min(0.75rem, 2.7vw);
          letter-spacing: -0.02em;
        }
        /* There is no room for eight; the night leads to its pictures. */
        .night-here .archive {
          display: none;
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
  @property({ attribute: false }) person: Me | null = null;
  /** There is something to drive, command or stop at the site. */
  @property({ type: Boolean }) actuable = false;
  /** The site has cameras that take exposures, or pictures of them, and the person may see them. */
  @property({ type: Boolean }) archived = false;
  /** The site has a telescope that the person may see. */
  @property({ type: Boolean }) observing = false;

  override render(): TemplateResult {
    const places = this.visiblePlaces();
    return html`<nav aria-label="Pages" class=${`${this.observing ? "night-here" : ""} ${places.length >= FULL ? "full" : ""}`}>
      ${map(
        places,
        (place) => html`<a
          class=${place.page}
          href=${this.pathOf(place.page) ?? nothing}
          aria-current=${this.isCurrent(place.page) ? "page" : nothing}
          aria-disabled=${this.pathOf(place.page) === null ? "true" : nothing}
          ><t-icon name=${place.icon}></t-icon>${place.title ?? PAGES[place.page].title}</a
        >`,
      )}
    </nav>`;
  }

  private visiblePlaces(): readonly NavigationPlace[] {
    const { person } = this;
    if (person === null) return [];
    // One beginning for each: the sites for who may see them, all public data for who sees no more.
    const hidden = seesOnlyPublic(person) ? "home" : "public";
    return PLACES.filter(
      ({ page }) => page !== hidden && mayOpen(page, person) && (page !== "drive" || this.actuable) && (page !== "archive" || this.archived) && (page !== "night" || this.observing),
    );
  }

  private isCurrent(page: NavigationPlace["page"]): boolean {
    if (page === "people") return ADMIN_PAGES.includes(this.page);
    return (
      page === this.page ||
      (page === "devices" && (this.page === "device" || this.page === "cameras")) ||
      (page === "live" && this.page === "topics") ||
      (page === "history" && this.page === "recordings") ||
      (page === "night" && ["forecast", "requests", "proposals", "alertrules"].includes(this.page)) ||
      (page === "alarms" && (this.page === "logbook" || this.page === "sightings"))
    );
  }

  /** Null when there is no site to go to. */
  private pathOf(page: NavigationPlace["page"]): string | null {
    switch (page) {
      case "people":
        return "/admin/people";
      case "home":
      case "public":
      case "devices":
      case "alarms":
        return `/${page}`;
      case "live":
      case "history":
      case "drive":
      case "archive":
      case "night":
        return this.site === "" ? null : sitePath(this.site, page);
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-nav": Navigation;
  }
}
