/** Top of every page: the name, the site, how the link stands, and who is signed in. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { TickerController } from "../../controllers/ticker.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { formatWholeMs } from "../../format/duration.js";
import { routerContext, sessionContext, sitesContext, themeContext } from "../../state/contexts.js";
import { pageAtOtherSite, sitePath, templatePath, type PageName, type Router } from "../../state/router.js";
import { THEMES } from "../../state/theme.js";
import type { Me } from "../../generated/api.js";
import type { LinkState } from "../../wire/connection.js";
import type { StatusKind } from "../../elements/feedback/status.js";
import { mayOpen, PAGES } from "../routes.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/base/icon.js";
import type { Menu } from "../../elements/layout/menu.js";
import "../../elements/layout/menu.js";
import "../../elements/feedback/status.js";

const LINKS: Readonly<Record<LinkState, readonly [StatusKind, string]>> = {
  idle: ["unknown", msg("not connected")],
  connecting: ["busy", msg("connecting")],
  open: ["online", msg("connected")],
  lost: ["offline", msg("connection lost")],
  ended: ["offline", msg("signed out")],
};

const LINK_TITLES: Readonly<Record<LinkState, string>> = {
  idle: msg("This page is not connected to the hub."),
  connecting: msg("This page is connecting to the hub."),
  open: msg("This page is connected to the hub. The time is how long a message takes there and back."),
  lost: msg("This page lost the hub. It is tried again by itself."),
  ended: msg("The hub ended this session."),
};

/** What the menu leads to: one's own account, and what has no place of its own on a phone. */
const WAYS: readonly (readonly [PageName, string])[] = [
  ["account", "/account"],
  ["public", "/public"],
  ["people", "/admin/people"],
  ["roles", "/admin/roles"],
  ["gateways", "/admin/gateways"],
  ["clients", "/admin/clients"],
  ["storage", "/admin/storage"],
  ["audit", "/admin/audit"],
];

const THEME_WORDS = { auto: msg("Auto"), light: msg("Light"), dark: msg("Dark"), night: msg("Night") } as const;
const THEME_OPTIONS = THEMES.map((id) => ({ id, label: THEME_WORDS[id] }));

@customElement("t-header")
export class Header extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: flex;
        align-items: center;
        gap: var(--t-space-2) var(--t-space-4);
        min-block-size: 3.5rem;
        padding-inline: max(var(--t-space-4), env(safe-area-inset-left));
        border-block-end: 1px solid var(--t-line);
        background: var(--t-surface);
      }
      .brand {
        display: inline-flex;
        align-items: center;
        gap: var(--t-space-2);
        min-block-size: var(--t-touch);
        color: var(--t-text);
        font-size: var(--t-size-l);
        font-weight: var(--t-weight-strong);
        letter-spacing: -0.01em;
        text-decoration: none;
      }
      .brand svg {
        inline-size: 1.5rem;
        block-size: 1.5rem;
        color: var(--t-accent);
      }
      select {
        min-block-size: var(--t-touch);
        flex: none;
        /* As wide as its name: which site it is must be read at a glance, and is never cut at a desk. */
        field-sizing: content;
        max-inline-size: 22rem;
        min-inline-size: 9.5rem;
        padding-inline: var(--t-space-2);
        border: 1px solid transparent;
        border-radius: var(--t-radius-s);
        background: var(--t-raised);
        color: var(--t-text);
        font: inherit;
        font-weight: var(--t-weight-strong);
        text-overflow: ellipsis;
      }
      .rest {
        display: flex;
        align-items: center;
        gap: var(--t-space-3);
        margin-inline-start: auto;
      }
      t-status {
        font-size: var(--t-size-s);
        white-space: nowrap;
      }
      .panel-who {
        display: grid;
      }
      .ways {
        display: grid;
        grid-template-columns: 1fr 1fr;
        gap: 0 var(--t-space-2);
        margin-inline: calc(-1 * var(--t-space-2));
      }
      .ways a {
        display: flex;
        align-items: center;
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-2);
        border-radius: var(--t-radius-s);
        color: var(--t-text);
        font-weight: var(--t-weight-strong);
        text-decoration: none;
      }
      .ways a:hover {
        background: var(--t-raised);
      }
      .ways a[aria-current] {
        color: var(--t-accent);
      }
      .name {
        overflow: hidden;
        text-overflow: ellipsis;
        max-inline-size: 9rem;
        white-space: nowrap;
      }
      .role {
        ${quietText}
      }
      @media (max-width: 85rem) {
        .name {
          display: none;
        }
      }
      @media (min-width: 60.01rem) and (max-width: 96rem) {
        /* A site's name is worth more than ours. */
        .brand.small .word {
          display: none;
        }
      }
      /* That all is well may go unsaid; what is not well is said at every width. */
      @media (max-width: 75rem) {
        t-status[kind="online"] {
          display: none;
        }
      }
      @media (max-width: 60rem) {
        :host {
          gap: var(--t-space-2);
        }
        .brand.small .word {
          display: none;
        }
        select {
          max-inline-size: 16rem;
        }
      }
      @media (max-width: 60rem) and (max-height: 30rem) {
        :host {
          min-block-size: 3rem;
        }
      }
      @media (max-width: 45rem) {
        :host {
          padding-inline: var(--t-space-3) var(--t-space-1);
          gap: var(--t-space-2);
        }
        .rest {
          gap: var(--t-space-1);
          min-inline-size: 0;
        }
        /* "Connection lost" in two lines: beside a site's name there is no room for one. */
        t-status {
          white-space: normal;
          line-height: 1.2;
        }
        select {
          flex: 0 1 auto;
          min-inline-size: 9rem;
          max-inline-size: 62vw;
        }
      }
    `,
  ];

  /** The site that the navigation leads to; empty for none. */
  @property() site = "";

  @query("t-menu") private readonly menu!: Menu;
  @consume({ context: routerContext }) private readonly router!: Router;
  private readonly link = new ConnectionStateController(this);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly theme = new ContextStoreController(this, themeContext);

  constructor() {
    super();
    new TickerController(this, 2000);
  }

  override render(): TemplateResult {
    const person = this.session.store?.person;
    return html`
      <a class=${person == null ? "brand" : "brand small"} href="/" aria-label=${msg("Talaia, home")}>
        <svg viewBox="0 0 32 32" aria-hidden="true">
          <path fill="currentColor" d="M9 28 11.5 13h9L23 28zM8 12V5h3v3h3V5h4v3h3V5h3v7z"></path>
        </svg>
        <span class="word">Talaia</span>
      </a>
      ${person == null ? nothing : this.renderSiteSwitch()}
      <slot></slot>
      <div class="rest">
        ${person == null ? nothing : this.renderLinkStatus()}
        <t-menu label=${person == null ? msg("Settings") : msg(str`${person.name}: settings and sign-out`)}>
          <t-icon slot="label" name="person"></t-icon>
          ${person == null ? nothing : html`<span slot="label" class="name">${person.name}</span>`}
          ${this.renderPanel()}
        </t-menu>
      </div>
    `;
  }

  private renderSiteSwitch(): unknown {
    const rows = this.sites.store?.list ?? [];
    if (rows.length === 0) return nothing;
    return html`<select aria-label=${msg("Site")} @change=${this.chooseSite}>
      ${repeat(
        rows,
        (row) => row.site,
        (row) => html`<option .value=${row.site} .selected=${row.site === this.site}>
          ${row.name}${row.online ? "" : msg(" (offline)")}
        </option>`,
      )}
    </select>`;
  }

  private renderLinkStatus(): TemplateResult {
    const [kind, word] = LINKS[this.link.state];
    const trip = this.link.connection?.roundTripMs ?? Number.NaN;
    const told = this.link.state === "open" && !Number.isNaN(trip) ? `${word} · ${formatWholeMs(trip)}` : word;
    return html`<t-status kind=${kind} word=${told} title=${LINK_TITLES[this.link.state]}></t-status>`;
  }

  private renderPanel(): TemplateResult {
    const person = this.session.store?.person;
    return html`
      ${person == null
        ? nothing
        : html`<div class="panel-who">
            <strong>${person.name}</strong><span class="role">${msg(str`signed in as ${person.role}`)}</span>
          </div>
          ${this.renderMenuLinks(person)}`}
      <t-choice
        label=${msg("Colours")}
        .options=${THEME_OPTIONS}
        .chosen=${this.theme.store?.theme ?? "auto"}
        @t-choose=${this.chooseTheme}
      ></t-choice>
      ${person == null ? nothing : html`<t-button @click=${this.signOut}>${msg("Log out")}</t-button>`}
    `;
  }

  private renderMenuLinks(person: Me): TemplateResult {
    const here = this.router.route.page;
    const ways = WAYS.filter(([page]) => mayOpen(page, person));
    return html`<div class="ways" @click=${this.closeMenu}>
      ${map(
        ways,
        ([page, path]) =>
          html`<a href=${path} aria-current=${page === here ? "page" : nothing}>${PAGES[page].title}</a>`,
      )}
    </div>`;
  }

  private readonly closeMenu = (): void => {
    this.menu.close();
  };

  private readonly chooseSite = (event: Event): void => {
    if (!(event.target instanceof HTMLSelectElement)) return;
    const page = this.router.route.page;
    if (page === "board") {
      this.router.navigate(templatePath(event.target.value));
      return;
    }
    this.router.navigate(sitePath(event.target.value, pageAtOtherSite(page)));
  };

  private readonly chooseTheme = (event: CustomEvent<string>): void => {
    const theme = THEMES.find((candidate) => candidate === event.detail);
    if (theme !== undefined) this.theme.store?.setTheme(theme);
  };

  private readonly signOut = (): void => {
    // The page first: it stands for everybody, so that nobody is sent to sign in again.
    this.menu.close();
    this.router.navigate("/logout");
    // The person is signed out here in any case; an unreachable hub ends the session by its time limit.
    void this.session.store?.logout().catch(() => undefined);
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-header": Header;
  }
}
