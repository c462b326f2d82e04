/** The frame around every page: header, navigation, banners, and the place where the page stands. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, query, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { apiContext, routerContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { allWords } from "../../words/language.js";
import { ADMIN_PAGES, localPath, type PageName } from "../../state/router.js";
import type { NightList, SiteShape, SiteSummary } from "../../generated/api.js";
import { ArchiveApi } from "../../wire/archive-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { isOpen, mayOpen, PAGES } from "../routes.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/feedback/problem.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";
import "./alarm-bar.js";
import "./code-alert.js";
import "./first-factor.js";
import "./header.js";
import "./interlock-bar.js";
import "./navigation.js";
import "./session-warning.js";
import "./storage-warning.js";

const WIDE_PAGES: readonly PageName[] = ["drive", "night"];

/** Pages whose words come with the frame; see FIRST_PAGES of vite.config.ts. */
const WITH_FIRST_WORDS: readonly PageName[] = ["login", "home"];

@customElement("t-shell")
export class Shell extends LitElement {
  static override styles = [
    base,
    css`
      :host {
        display: grid;
        /* Not wider than the window, whatever a site is called. */
        grid-template-columns: minmax(0, 1fr);
        grid-template-rows: auto 1fr;
        min-block-size: 100dvh;
      }
      .top {
        position: sticky;
        inset-block-start: 0;
        z-index: 20;
      }
      main {
        inline-size: 100%;
        max-inline-size: 96rem;
        margin-inline: auto;
        padding: var(--t-space-5) max(var(--t-space-4), env(safe-area-inset-left)) var(--t-space-6);
        outline: none;
        min-inline-size: 0;
      }
      /* Cockpits: whoever sits in front of a large screen wants all of it. */
      main.wide {
        max-inline-size: 170rem;
      }
      /* A phone on its side: height is what there is least of. */
      @media (max-height: 30rem) {
        main {
          padding-block: var(--t-space-3);
        }
      }
      main:focus-visible {
        outline: none;
      }
      .skip {
        position: absolute;
        inset-block-start: -10rem;
        inset-inline-start: var(--t-space-2);
        z-index: 40;
        padding: var(--t-space-2) var(--t-space-4);
        border-radius: var(--t-radius-s);
        background: var(--t-accent);
        color: var(--t-on-accent);
      }
      .skip:focus {
        inset-block-start: var(--t-space-2);
      }
      .bottom {
        display: none;
      }
      /* A phone has its pages below, and one on its side has no height for a row. */
      @media (max-width: 45rem), (max-height: 30rem) {
        .site-row {
          display: none;
        }
      }
      @media (max-width: 45rem) {
        main {
          padding: var(--t-space-4) var(--t-space-3) calc(5.5rem + env(safe-area-inset-bottom));
        }
        .beside {
          display: none;
        }
        .bottom {
          display: block;
          position: fixed;
          inset-block-end: 0;
          inset-inline: 0;
          z-index: 20;
        }
      }
    `,
  ];

  /** The hub did not answer when it was last asked. */
  @property({ type: Boolean }) unreachable = false;

  /** The hub has newer pages than those that run here. */
  @property({ type: Boolean }) outdated = false;

  @state() private page: HTMLElement | null = null;
  @state() private broken = false;

  @query("main") private readonly main!: HTMLElement;

  private shown = "";
  private shownPath = "";
  private lastSite = "";
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly link = new ConnectionStateController(this);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly nights = new LoadController<NightList>(this);
  @consume({ context: apiContext }) private readonly api: HubApi | undefined;

  override connectedCallback(): void {
    super.connectedCallback();
    this.addEventListener("click", this.onLinkClick);
    this.addEventListener("t-site", this.onSite);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.removeEventListener("click", this.onLinkClick);
    this.removeEventListener("t-site", this.onSite);
  }

  override willUpdate(): void {
    const route = this.router.store?.route;
    if (route !== undefined && route.site !== "") this.lastSite = route.site;
    this.loadSiteDetail();
    void this.loadPage();
  }

  /** Whether there is anything to drive, command or stop is in the site's description alone. */
  private loadSiteDetail(): void {
    const sites = this.sites.store;
    const site = this.siteNow();
    if (sites === undefined || site === "" || this.session.store?.person?.factor_missing !== false) return;
    const question = [site, sites.catalogueOf(site), this.session.store.rightsKey].join("\n");
    this.detail.load(question, () => sites.loadDetail(site));
    const { api } = this;
    if (api !== undefined) this.nights.load(`${question}\n${this.router.store?.route.page ?? ""}`, () => new ArchiveApi(api, site).nights());
  }

  /** Whether there is an archive, and whether one may see it, only the archive knows. */
  private hasArchive(): boolean {
    return (this.nights.value?.nights.length ?? 0) > 0;
  }

  private siteNow(): string {
    return this.lastSite || (this.sites.store?.list[0]?.site ?? "");
  }

  private hasActuators(): boolean {
    const devices = this.detail.value?.devices ?? [];
    return devices.some(({ drive, commands }) => drive !== null || commands.length > 0);
  }

  override render(): TemplateResult {
    const person = this.session.store?.person ?? null;
    const inside = person !== null && !person.factor_missing;
    const page = this.router.store?.route.page ?? "home";
    const site = this.siteNow();
    const actuable = this.hasActuators();
    const archived = this.hasArchive();
    const observing = this.detail.value?.devices.some(({ kind }) => kind === "telescope") ?? false;
    return html`
      <div class="top" role="banner">
        <a class="skip" href="#main" @click=${this.focusContent}>${msg("Skip to the page")}</a>
        <t-header .site=${site}>
          ${inside ? html`<t-nav class="beside" .page=${page} .site=${site} .person=${person} ?actuable=${actuable} ?archived=${archived} ?observing=${observing}></t-nav>` : nothing}
        </t-header>
        ${inside && site !== "" && !ADMIN_PAGES.includes(page) && page !== "account"
          ? html`<t-nav class="site-row" row .name=${this.sites.store?.siteRow(site)?.name ?? site} .page=${page} .site=${site} .person=${person} ?actuable=${actuable} ?archived=${archived} ?observing=${observing}></t-nav>`
          : nothing}
        ${this.renderBanner()} ${inside ? html`<t-session-end></t-session-end>` : nothing}
        ${inside ? html`<t-alarm-bar></t-alarm-bar>${this.renderInterlocks()}` : nothing}
        ${inside && person.codes_locked_us > 0 ? html`<t-code-alert></t-code-alert>` : nothing}
        ${inside && person.admin ? html`<t-storage-warning></t-storage-warning>` : nothing}
      </div>
      <main id="main" tabindex="-1" class=${WIDE_PAGES.includes(page) ? "wide" : ""}>${this.renderContent()}</main>
      ${inside ? html`<t-nav class="bottom" below .page=${page} .site=${site} .person=${person} ?actuable=${actuable} ?archived=${archived} ?observing=${observing}></t-nav>` : nothing}
    `;
  }

  private renderInterlocks(): TemplateResult {
    const route = this.router.store?.route;
    const steady = route?.page === "drive" || route?.page === "device";
    return html`<t-interlocks .site=${route?.site ?? ""} ?steady=${steady}></t-interlocks>`;
  }

  private renderContent(): unknown {
    if (this.broken) {
      return html`<t-problem
        what=${msg("This page could not be loaded.")}
        how=${msg("The hub may have been updated, or the network is gone.")}
        retry=${msg("Load again")}
        @t-retry=${this.reloadPage}
      ></t-problem>`;
    }
    const person = this.session.store?.person ?? null;
    const place = this.router.store?.route.page ?? "missing";
    if (person?.factor_missing === true && !isOpen(place)) return html`<t-first-factor></t-first-factor>`;
    const admins = ADMIN_PAGES.includes(place);
    // An empty list would say that all is well.
    if (person !== null && (admins || place === "alarms" || place === "logbook" || place === "log") && !mayOpen(place, person)) {
      return html`<t-empty heading=${admins ? msg("Only admins may open this") : msg("This is not open to you")} icon="lock" page>
        <p>${msg(str`You are signed in as ${person.name}, with the role ${person.role}. An admin of this hub can give you another.`)}</p>
        <p><a href="/">${msg("Go to your first page")}</a></p>
      </t-empty>`;
    }
    if (this.page !== null) return this.page;
    if (this.unreachable) {
      return html`<t-problem
        what=${msg("The hub cannot be reached.")}
        how=${msg("Check the network and that the hub is running. It is tried again every few seconds.")}
      ></t-problem>`;
    }
    return html`<t-loading what=${msg("Opening Talaia")}></t-loading>`;
  }

  private renderBanner(): unknown {
    if (this.session.store?.person?.factor_missing !== false) return nothing;
    if (this.link.state === "lost") {
      return html`<t-banner kind="bad"
        >${msg("No connection to the hub. What you see is old; it is tried again by itself.")}</t-banner
      >`;
    }
    const rivals = this.sites.store?.list.filter((row) => row.rival_us > 0) ?? [];
    return html`${repeat(rivals, ({ site }) => site, renderRivalry)} ${this.renderMissing()} ${this.renderUnreachable()} ${this.renderOutdated()}`;
  }

  /** Of several hubs that divide sites among them, one is away. */
  private renderMissing(): unknown {
    const missing = this.sites.store?.missing ?? [];
    if (missing.length === 0) return nothing;
    const names = missing.join(", ");
    return html`<t-banner kind="bad">${msg(str`The hub that has the sites of ${names} cannot be reached. Nothing is known of them now; it is tried again by itself.`)}</t-banner>`;
  }

  /** Nobody's page is loaded anew behind their back: they may be driving. */
  private renderOutdated(): unknown {
    if (!this.outdated) return nothing;
    return html`<t-banner
      >${msg("Talaia was updated while this page was open.")} <t-button kind="quiet" @click=${this.reloadPage}>${msg("Load the new page")}</t-button></t-banner
    >`;
  }

  private renderUnreachable(): unknown {
    const row = this.sites.store?.siteRow(this.router.store?.route.site ?? "");
    if (row === undefined || row.online) return nothing;
    return html`<t-banner kind="warn"
      >${msg(html`${row.name} has been offline since <t-time .us=${row.since_us} .zone=${row.zone}></t-time>. Values are the last known.`)}</t-banner
    >`;
  }

  private async loadPage(): Promise<void> {
    const route = this.router.store?.route;
    if (route === undefined || this.session.store?.state === "unknown") return;
    // With other rights a page begins anew: nothing of what it showed is kept.
    const key = [route.page, route.site, route.device, this.session.store?.rightsKey ?? ""].join("\n");
    if (key === this.shown) return;
    const first = this.shown === "";
    const same = this.shownPath === this.router.store?.path;
    this.shownPath = this.router.store?.path ?? "";
    this.shown = key;
    const entry = PAGES[route.page];
    try {
      if (!WITH_FIRST_WORDS.includes(route.page)) await allWords();
      await entry.load();
    } catch {
      if (this.shown === key) this.broken = true;
      return;
    }
    if (this.shown !== key) return;
    const page = document.createElement(entry.tag);
    if ("site" in page) page.site = route.site;
    if (route.device !== "" && "device" in page) page.device = route.device;
    this.page = page;
    this.broken = false;
    document.title = this.titleOf(entry.title, route.site);
    if (first || same) return;
    window.scrollTo(0, 0);
    await this.updateComplete;
    // Whoever moves by keyboard or listens starts at the new page, unless it took the focus itself.
    if (!page.matches(":focus-within")) this.main.focus({ preventScroll: true });
  }

  private titleOf(title: string, site: string): string {
    const name = this.sites.store?.siteRow(site)?.name ?? site;
    return [title, ...(name === "" ? [] : [name]), "Talaia"].join(" · ");
  }

  private readonly reloadPage = (): void => {
    location.reload();
  };

  private readonly focusContent = (event: Event): void => {
    event.preventDefault();
    this.main.focus();
  };

  /** A page whose address does not name its site says which one it shows. */
  private readonly onSite = (event: Event): void => {
    if (!(event instanceof CustomEvent)) return;
    this.lastSite = String(event.detail);
    this.requestUpdate();
  };

  /** Links of ours change the page without loading everything anew. */
  private readonly onLinkClick = (event: MouseEvent): void => {
    if (event.defaultPrevented || event.button !== 0 || event.ctrlKey || event.metaKey || event.shiftKey || event.altKey) {
      return;
    }
    const link = event.composedPath().find((node) => node instanceof HTMLAnchorElement);
    if (link === undefined || link.target !== "" || link.hasAttribute("download")) return;
    const path = localPath(link.href, location.origin);
    if (path === null) return;
    event.preventDefault();
    this.router.store?.navigate(path);
  };
}

/** Two gateways with one identity: a copied key, or a machine that was forgotten. */
function renderRivalry(row: SiteSummary): TemplateResult {
  return html`<t-banner kind="bad"
    >${msg(html`A second gateway uses the key of ${row.name}; it was last there at <t-time .us=${row.rival_us} .zone=${row.zone}></t-time>. Only one is linked and can drive; STOP reaches both while the other waits. An admin decides under <a href="/admin/gateways">Gateways</a>. Switch the other one off, or enrol one of them anew.`)}</t-banner
  >`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-shell": Shell;
  }
}
