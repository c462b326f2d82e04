/** The places of the dashboard that a person may open: beside the name on a desk, under the thumb on a phone. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base } from "../../elements/base/base-style.js";
import type { IconName } from "../../elements/base/icons.js";
import { seesOnlyPublic } from "../../state/rights.js";
import { ADMIN_PAGES, isPlanningPage, sitePath, type PageName } from "../../state/router.js";
import type { Me } from "../../generated/api.js";
import { mayOpen, PAGES } from "../routes.js";
import { morePlaces, rowPageOf, sitePages } from "./more-places.js";
import "../../elements/base/icon.js";
import type { Menu } from "../../elements/layout/menu.js";
import "../../elements/layout/menu.js";

interface NavigationPlace {
  readonly page: "home" | "boards" | "public" | "devices" | "live" | "history" | "alarms" | "drive" | "archive" | "night" | "people";
  readonly icon: IconName;
  readonly title?: string;
  /** In the bar of a phone, where a seventh of the width is its own. */
  readonly brief?: string;
}

const PLACES: readonly NavigationPlace[] = [
  { page: "home", icon: "home" },
  { page: "public", icon: "open" },
  { page: "boards", icon: "boards" },
  { page: "devices", icon: "devices", brief: msg("Devices", { id: "devices.brief" }) },
  { page: "live", icon: "live", brief: msg("Real-time", { id: "real-time.brief" }) },
  { page: "history", icon: "history" },
  { page: "alarms", icon: "bell" },
  { page: "drive", icon: "drive" },
  { page: "night", icon: "moon" },
  { page: "archive", icon: "camera", brief: msg("Archive", { id: "archive.brief" }) },
  { page: "people", icon: "shield", title: msg("Admin") },
];

/** So many places leave no room for their icons beside a site's name. */
const FULL = 8;

/** Where the window is narrow, an observatory has these behind *More*. */
const SPARE: readonly PageName[] = ["devices", "archive"];

/** Of the places, those that are a site's own. */
const OF_SITE: readonly PageName[] = ["live", "history", "drive", "night", "archive"];

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
      t-menu {
        --t-menu-width: 12rem;
        color: var(--t-muted);
        font-weight: var(--t-weight-strong);
      }
      t-menu::part(button) {
        min-block-size: 3.5rem;
        font-weight: inherit;
        /* As of the links beside it: the header has no room around them. */
        outline-offset: -4px;
      }
      t-menu.here {
        color: var(--t-text);
      }
      /* All of a site's pages, in a row of their own. */
      .row {
        flex-wrap: wrap;
        gap: 0 var(--t-space-1);
        padding-inline: max(var(--t-space-3), env(safe-area-inset-left));
        border-block-end: 1px solid var(--t-line);
        background: var(--t-surface);
      }
      .row a {
        min-block-size: 2.5rem;
        padding-inline: var(--t-space-2);
        font-size: var(--t-size-s);
      }
      /* They stand in that row, wherever there is the height for it. */
      @media (min-width: 45.01rem) and (min-height: 30.01rem) {
        .of-site {
          display: none;
        }
      }
      .more {
        display: grid;
      }
      .more a {
        flex-direction: row;
        justify-content: start;
        min-block-size: var(--t-touch);
        border: 0;
        font-size: var(--t-size-m);
        letter-spacing: normal;
      }
      .more a[aria-current] {
        color: var(--t-accent);
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
        }
        a,
        t-menu {
          font-size: var(--t-size-s);
        }
      }
      @media (max-width: 45rem), (max-width: 75rem) and (max-height: 30rem) {
        .spare {
          display: none;
        }
      }
      @media (min-width: 75.01rem) {
        .spared {
          display: none;
        }
      }
      @media (max-width: 75rem) and (min-width: 45.01rem) {
        nav > a > t-icon {
          display: none;
        }
      }
      @media (max-width: 75rem) and (min-width: 45.01rem) {
        /* The tower at the edge leads home, too. */
        .home {
          display: none;
        }
      }
      @media (max-width: 52rem) and (min-width: 45.01rem) {
        nav > a {
          padding-inline: var(--t-space-1);
        }
      }
      @media (max-width: 52rem) and (min-width: 45.01rem) and (max-height: 30rem) {
        .people {
          display: none;
        }
      }
      /* With all of them the site's name would have no room. */
      @media (max-width: 96rem) and (min-width: 45.01rem) {
        .full > a > t-icon {
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
        }
        /* A longer word of another language ends with dots before it runs into the next. */
        a > span {
          max-inline-size: 100%;
          overflow: hidden;
          text-overflow: ellipsis;
          white-space: nowrap;
        }
        /* An admin's work is done at a desk; on a phone the menu of one's name leads there. */
        .people {
          display: none;
        }
        /* Seven of them stand side by side: the longest word is as wide as its seventh. */
        a,
        t-menu {
          font-size: min(0.75rem, 2.7vw);
          letter-spacing: -0.02em;
        }
        t-menu {
          flex: 1;
          min-inline-size: 0;
        }
        t-menu::part(button) {
          inline-size: 100%;
          flex-direction: column-reverse;
          justify-content: center;
          gap: 2px;
          padding-inline: 0;
        }
        nav > a[aria-current] {
          border-block-start-color: var(--t-accent);
          border-block-end-color: transparent;
          color: var(--t-accent);
        }
      }
    `,
  ];

  @query("t-menu") private readonly menu!: Menu | null;
  /** It is the row of a site's own pages. */
  @property({ type: Boolean }) row = false;
  /** What the site is called. */
  @property() name = "";
  /** It stands at the lower edge of the window. */
  @property({ type: Boolean }) below = false;
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
    if (this.row) return this.renderRow();
    const places = this.visiblePlaces();
    const atDesk = places.filter(({ page }) => page !== "people");
    const admins = places.filter(({ page }) => page === "people");
    return html`<nav aria-label=${msg("Pages")} class=${places.length >= FULL ? "full" : ""}>
      ${this.renderPlaces(atDesk)} ${this.renderMore()} ${this.renderPlaces(admins)}
    </nav>`;
  }

  private renderRow(): TemplateResult {
    const pages = this.person === null ? [] : sitePages(this.site, this.person, this);
    const here = rowPageOf(this.page);
    return html`<nav class="row" aria-label=${msg(str`Pages of ${this.name}`)}>
      ${map(pages, ({ page, title, path }) => html`<a href=${path} aria-current=${page === here ? "page" : nothing}>${title}</a>`)}
    </nav>`;
  }

  private renderPlaces(places: readonly NavigationPlace[]): unknown {
    return map(
        places,
        (place) => html`<a
          class="${place.page} ${!this.below && OF_SITE.includes(place.page) ? "of-site" : ""} ${place.page === "boards" || (this.observing && SPARE.includes(place.page)) ? "spare" : ""}"
          href=${this.pathOf(place.page) ?? nothing}
          aria-current=${this.isCurrent(place.page) ? "page" : nothing}
          aria-disabled=${this.pathOf(place.page) === null ? "true" : nothing}
          ><t-icon name=${place.icon}></t-icon><span>${(this.below ? place.brief : undefined) ?? place.title ?? PAGES[place.page].title}</span></a
        >`,
      );
  }

  /** What of the site has no place beside the others. */
  private renderMore(): unknown {
    const { site, person, observing, archived } = this;
    const more = person === null ? [] : morePlaces(site, person, { observing, archived });
    if (more.length === 0) return nothing;
    const here = more.some(({ page, spared }) => page === this.page && !spared);
    return html`<t-menu ?up=${this.below} class="${here ? "here" : ""} ${this.below ? "" : "of-site"}">
      <span slot="label">${msg("More")}</span>
      <div class="more" @click=${this.closeMenu}>
        ${map(
          more,
          ({ page, title, path, spared }) => html`<a class=${spared ? "spared" : ""} href=${path} aria-current=${page === this.page ? "page" : nothing}>${title}</a>`,
        )}
      </div>
    </t-menu>`;
  }

  private readonly closeMenu = (): void => {
    this.menu?.close();
  };

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
      (page === "boards" && this.page === "board") ||
      (page === "devices" && (this.page === "device" || this.page === "cameras" || this.page === "zones")) ||
      (page === "live" && ["topics", "scene"].includes(this.page)) ||
      (page === "history" && this.page === "recordings") ||
      (page === "night" && isPlanningPage(this.page)) ||
      (page === "alarms" && ["logbook", "log", "notes", "anomalies", "cause", "sightings", "review"].includes(this.page))
    );
  }

  /** Null when there is no site to go to. */
  private pathOf(page: NavigationPlace["page"]): string | null {
    switch (page) {
      case "people":
        return "/admin/people";
      case "home":
      case "public":
      case "boards":
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
