/** Several sites at once: STOP for them, and one command that they share. Never driving. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { GroupCommandClient } from "../../controllers/drive/group-command-client.js";
import { GroupStopClient } from "../../controllers/drive/group-stop-client.js";
import { LoadController } from "../../controllers/load.js";
import { RefreshController } from "../../controllers/refresh.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import type { SharedCommandList } from "../../generated/api.js";
import { apiContext, connectionContext, sitesContext } from "../../state/contexts.js";
import type { Connection } from "../../wire/connection.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { FleetStop } from "./fleet-stop.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "./fleet-chooser.js";
import "./fleet-command.js";
import "./fleet-stop.js";

/** States and new sites are asked for anew (ms). */
const EVERY_MS = 5000;

@customElement("t-page-fleet")
export class PageFleet extends LitElement {
  static override styles = [
    base,
    sheets,
  ];

  @state() private chosen: ReadonlySet<string> = new Set();
  @state() private stopLine: GroupStopClient | null = null;
  @state() private commandLine: GroupCommandClient | null = null;
  @query("t-fleet-stop") private readonly stop!: FleetStop | null;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  @consume({ context: connectionContext }) private readonly connection!: Connection;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly commands = new LoadController<SharedCommandList>(this);
  protected readonly refresh = new RefreshController(this, EVERY_MS, () => {
    if (this.sites.store?.status === "ready") void this.sites.store.load();
  });

  override connectedCallback(): void {
    super.connectedCallback();
    this.stopLine = new GroupStopClient(this.connection);
    this.stopLine.open();
    this.commandLine = new GroupCommandClient(this.connection);
    this.commandLine.open();
    window.addEventListener("keydown", this.onKeyDown);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    window.removeEventListener("keydown", this.onKeyDown);
    this.stopLine?.close();
    this.commandLine?.close();
  }

  override willUpdate(): void {
    const sites = this.sites.store;
    const catalogues = (sites?.list ?? []).map(({ site }) => `${site} ${sites?.catalogueOf(site) ?? ""}`).join();
    this.commands.load(catalogues, () => this.api.request<SharedCommandList>("GET", "/api/commands"));
  }

  override render(): TemplateResult {
    return html`${renderPageHead(msg("Fleet"), msg("One command or STOP for several robots. Each decides by its own rights and interlocks; nothing is driven from here."))} ${this.renderSites()}`;
  }

  private renderSites(): unknown {
    const sites = this.sites.store;
    if (sites === undefined || sites.status === "idle" || (sites.status === "loading" && sites.list.length === 0)) return html`<t-loading what=${msg("Loading your sites")}></t-loading>`;
    if (sites.status === "failed" && sites.list.length === 0) return renderAdvice(adviceFor(sites.renderError, msg("the list of sites")), () => void sites.load());
    if (sites.list.length === 0) return html`<t-empty heading=${msg("No sites yet")} icon="unlinked"><p>${msg("A site appears here once its gateway has connected to this hub, and you have the right to view it.")}</p></t-empty>`;
    const rows = sites.list;
    const chosen = rows.filter(({ site }) => this.chosen.has(site));
    return html`
      <t-fleet-stop .rows=${chosen.length > 0 ? chosen : rows} ?partial=${chosen.length > 0} .line=${this.stopLine}></t-fleet-stop>
      <section class="sheet" aria-label=${msg("Sites")}>
        <h2>${msg("Sites")}</h2>
        <t-fleet-chooser .rows=${rows} .chosen=${this.chosen} @t-choose-sites=${this.onChoose}></t-fleet-chooser>
        <p role="status" class="muted">${chosen.length === 0 ? msg("None is chosen: STOP is for all of them.") : msg(str`${String(chosen.length)} chosen: STOP and the command are for these.`)}</p>
      </section>
      <section class="sheet" aria-label=${msg("Command")}>
        <h2>${msg("Command")}</h2>
        ${renderLoaded(this.commands, msg("the commands"), ({ commands }) => html`<t-fleet-command .chosen=${chosen} .commands=${commands} .line=${this.commandLine}></t-fleet-command>`)}
      </section>
    `;
  }

  private readonly onChoose = (event: CustomEvent<readonly string[]>): void => {
    this.chosen = new Set(event.detail);
  };

  /** As on the page of one robot: Escape is STOP, wherever the focus is. */
  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.key === "Escape" && !event.repeat) this.stop?.pressStop();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-fleet": PageFleet;
  }
}
