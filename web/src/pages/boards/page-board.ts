/** One board: looked at, arranged, saved with versions, shared, exported, and filling a screen. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { nextInCycle, readBoardQuery, writeBoardQuery } from "../../boards/board-query.js";
import type { GridItem, GridName } from "../../boards/grid.js";
import { boardDevice } from "../../boards/references.js";
import { readTemplateKey, templateOf } from "../../boards/templates.js";
import { ActionController } from "../../controllers/action.js";
import { ConnectionStateController } from "../../controllers/connection-state.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { QuestionController } from "../../controllers/question.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderQuestion } from "../../elements/feedback/question.js";
import type { ChoiceOption } from "../../elements/forms/choice.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { adviceFor } from "../../format/error-advice.js";
import type { BoardDetail, BoardRow, BoardShape, BoardTileShape, DeviceShape, SiteShape, TileList } from "../../generated/api.js";
import { timeText } from "../../format/time.js";
import { apiContext, routerContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { boardKeyOf, boardPath, withQuery } from "../../state/router.js";
import type { PastBoard } from "../../state/past/past-board.js";
import { boardTileEntry } from "../../tiles/board/board-catalog.js";
import { BoardsApi } from "../../boards/boards-api.js";
import { Refused, type HubApi } from "../../wire/hub-api.js";
import { BoardPast } from "./board-past.js";
import { BoardDraft } from "./board-draft.js";
import { boardStyle } from "./board-style.js";
import "../../elements/feedback/banner.js";
import "../../elements/feedback/dialog.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/loading.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";
import "../../elements/forms/field.js";
import "../../elements/layout/menu.js";
import "./board-dialogs.js";
import "./board-form.js";
import "./board-view.js";
import "./tile-form.js";

const GRIDS: readonly ChoiceOption[] = [
  { id: "desktop", label: msg("Desktop") },
  { id: "phone", label: msg("Phone") },
];
const RUNS: readonly string[] = [msg("First run"), msg("Second run")];
const PHONE = "(max-width: 45rem)";

/** @fires t-site which site it shows: the dashboard around it is then of that site, too */
@customElement("t-page-board")
export class PageBoard extends LitElement {
  static override styles = [base, sheets, control, boardStyle];

  @property({ type: Boolean, reflect: true }) kiosk = false;
  @state() private draft: BoardDraft | null = null;
  @state() private draftKey = 0;
  @state() private grid: GridName = "desktop";
  @state() private narrow = matchMedia(PHONE).matches;
  @state() private open: "" | "add" | "versions" | "share" = "";
  @state() private settingsOf = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly link = new ConnectionStateController(this);
  private readonly kept = new LoadController<BoardDetail>(this);
  private readonly detail = new LoadController<SiteShape>(this);
  private readonly tiles = new LoadController<TileList>(this);
  private readonly action = new ActionController(this);
  private readonly removing = new QuestionController<BoardRow>(this, (row, action) => this.removeBoard(row, action));
  private readonly past = new BoardPast(this, () => this.api, (at, against) => {
    this.replaceQuery({ at, against });
  });
  private readonly width = matchMedia(PHONE);
  private shownKey = "";
  private cycling: ReturnType<typeof setTimeout> | undefined;
  private cycled = "";
  private announced = "";

  override connectedCallback(): void {
    super.connectedCallback();
    this.width.addEventListener("change", this.onWidth);
    document.addEventListener("fullscreenchange", this.onFullScreenChange);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.width.removeEventListener("change", this.onWidth);
    document.removeEventListener("fullscreenchange", this.onFullScreenChange);
    clearTimeout(this.cycling);
  }

  protected override willUpdate(): void {
    const { key, query } = this;
    const sites = this.sites.store;
    if (key !== this.shownKey) {
      this.shownKey = key;
      this.draft = null;
      this.open = "";
      this.action.clear();
    }
    this.kiosk = query.kiosk;
    this.followCycle();
    const template = readTemplateKey(key);
    if (template === null) this.kept.load(key, () => new BoardsApi(this.api).readBoard(key));
    const site = this.shownSite;
    this.announceSite(site);
    if (sites !== undefined && site !== "") this.detail.load(`${site} ${sites.catalogueOf(site)}`, () => sites.loadDetail(site));
    this.past.follow(this.draft === null ? site : "", query);
    this.tiles.load("tiles", () => this.api.request<TileList>("GET", "/api/tiles"));
    if (query.arrange && this.draft === null && this.kept.value?.row.key === key && this.row?.may_change === true) this.beginArranging();
  }

  override render(): unknown {
    const trouble = this.renderTrouble();
    if (trouble !== null) return trouble;
    const { board } = this;
    const detail = this.detail.value;
    if (board === null || detail === undefined) return html`<t-loading what=${msg("Loading the board")}></t-loading>`;
    const view = this.renderView(board, detail);
    if (this.kiosk) return html`<h1 class="visually-hidden">${board.name}</h1>${this.renderKioskBar()}${this.past.renderBar(detail, this.query)}${view}`;
    return html`${this.renderHead(board, detail)} ${renderAdvice(this.action.problem)}<p class="said" role="status">${this.action.doneText}</p>
      ${this.draft === null ? nothing : this.renderArrangeBar(board, detail)} ${this.past.renderBar(detail, this.query)} ${view} ${this.renderDialogs(board, detail)}`;
  }

  // ── what is shown ───────────────────────────────────────────────────────────────────────

  private get key(): string {
    return boardKeyOf(this.router.store?.path ?? "");
  }

  private get query(): ReturnType<typeof readBoardQuery> {
    return readBoardQuery(this.router.store?.search ?? "");
  }

  private get row(): BoardRow | null {
    const row = this.kept.value?.row ?? null;
    return row?.key === this.key ? row : null;
  }

  /** As it is kept, or made of the description; null before it is known. */
  private get keptBoard(): BoardShape | null {
    const { key } = this;
    if (readTemplateKey(key) !== null) return this.detail.value === undefined ? null : templateOf(this.detail.value, key);
    return this.row === null ? null : (this.kept.value?.board ?? null);
  }

  private get board(): BoardShape | null {
    return this.draft?.board ?? this.keptBoard;
  }

  private get shownSite(): string {
    const template = readTemplateKey(this.key);
    if (template !== null) return template.site;
    const list = this.sites.store?.list ?? [];
    const asked = this.query.site || (this.row === null ? "" : (this.kept.value?.board.site ?? ""));
    return asked || (this.row === null ? "" : (list[0]?.site ?? ""));
  }

  private announceSite(site: string): void {
    if (site === this.announced || site === "") return;
    this.announced = site;
    this.dispatchEvent(new CustomEvent("t-site", { detail: site, bubbles: true, composed: true }));
  }

  private renderTrouble(): unknown {
    const template = readTemplateKey(this.key);
    const failed = template === null && this.kept.result.state === "failed" ? this.kept.result.error : null;
    if (failed !== null) {
      if (failed instanceof Refused && failed.status === 404) return this.renderMissing(msg("There is no such board, or it is not shared with you."));
      return renderAdvice(adviceFor(failed, msg("the board")), this.kept.invalidate);
    }
    if (this.detail.result.state === "failed") {
      const { error } = this.detail.result;
      if (error instanceof Refused && error.status === 404) return this.renderMissing(msg("Its site is not known here, or your role may not see it."));
      return renderAdvice(adviceFor(error, msg("the board's site")), this.detail.invalidate);
    }
    if (template !== null && this.detail.value !== undefined && this.keptBoard === null) return this.renderMissing(msg("The description has nothing that it is made of any more."));
    if (this.sites.store?.status === "ready" && this.shownSite === "" && this.row !== null) return this.renderMissing(msg("No site is connected yet: a board shows one."));
    return null;
  }

  private renderMissing(why: string): TemplateResult {
    return html`<h1>${msg("Board")}</h1><t-empty heading=${msg("This board is not open to you")} icon="lock"><p>${why}</p><p><a href="/boards">${msg("All boards")}</a></p></t-empty>`;
  }

  private renderView(board: BoardShape, detail: SiteShape): TemplateResult {
    const arranging = this.draft !== null;
    const grid = arranging ? this.grid : this.narrow ? "phone" : "desktop";
    const { board: run, other } = this.past;
    if (run !== null && other !== null) return this.renderRuns(board, detail, [run, other]);
    return html`<t-board-view
      class=${arranging && grid === "phone" ? "phone" : ""}
      .board=${board}
      .detail=${detail}
      .device=${this.device(board, detail)}
      .extensions=${this.tiles.value?.tiles ?? []}
      .grid=${grid}
      .past=${run}
      ?editing=${arranging}
      @t-arrange=${this.onArrange}
      @t-settings=${this.onSettings}
      @t-remove=${this.onRemove}
    ></t-board-view>`;
  }

  /** Two runs side by side, each tile as a phone has it: half a screen is as narrow. */
  private renderRuns(board: BoardShape, detail: SiteShape, runs: readonly PastBoard[]): TemplateResult {
    const { zone } = detail;
    const views = runs.map(
      (past, at) => html`<section aria-label=${RUNS[at] ?? ""}>
        <h2 class="run">${RUNS[at]} <span>${timeText(past.us, zone, Date.now() * 1000).local}</span></h2>
        <t-board-view .board=${board} .detail=${detail} .device=${this.device(board, detail)} .extensions=${this.tiles.value?.tiles ?? []} grid="phone" .past=${past}></t-board-view>
      </section>`,
    );
    return html`<div class="runs">${views}</div>`;
  }

  private device(board: BoardShape, detail: SiteShape): DeviceShape | null {
    return boardDevice(detail, this.query.device, board);
  }

  private renderHead(board: BoardShape, detail: SiteShape): TemplateResult {
    const { row } = this;
    const display = this.session.store?.person?.role === "display";
    return html`<div class="head">
      <div>
        <p class="muted"><a href="/boards">${msg("Boards")}</a>${row === null ? msg(" · made of the description") : row.described ? msg(" · of the site's description") : msg(str` · of ${row.owner}, version ${String(row.number)}`)}</p>
        <h1>${board.name}</h1>
        ${this.renderSubjects(board, detail)}
      </div>
      ${this.draft !== null || display
        ? nothing
        : html`<div class="tools">
            ${row?.may_change === true
              ? html`<t-button @click=${this.beginArranging}>${msg("Arrange")}</t-button>`
              : html`<t-button ?busy=${this.action.busy} @click=${this.saveCopy}>${msg("Save a copy to arrange")}</t-button>`}
            ${this.past.board === null ? html`<t-button @click=${this.past.lookBack}>${msg("Look back")}</t-button>` : nothing}
            <t-button @click=${this.fillScreen}>${msg("Fill the screen")}</t-button>
            <t-menu label=${msg("More of this board")}><span slot="label">${msg("More")}</span>
              ${row === null || row.described ? nothing : html`<t-button @click=${this.onVersions}>${msg("Versions…")}</t-button>`}
              ${row?.may_change === true ? html`<t-button @click=${this.onShare}>${msg("Share…")}</t-button>` : nothing}
              <t-button @click=${this.exportFile}>${msg("Export as YAML")}</t-button>
              ${row?.may_change === true ? html`<t-button @click=${this.saveCopy}>${msg("Save a copy")}</t-button><t-button kind="danger" @click=${this.removing.opener(row)}>${msg("Remove…")}</t-button>` : nothing}
            </t-menu>
          </div>`}
    </div>`;
  }

  /** What the board is looked at with: it serves every robot of its kind. */
  private renderSubjects(board: BoardShape, detail: SiteShape): unknown {
    const list = this.sites.store?.list ?? [];
    const fits = detail.devices.filter(({ kind }) => board.kind === "" || kind === board.kind);
    const device = this.device(board, detail);
    const free = readTemplateKey(this.key) === null && list.length > 1 && board.site === "";
    const uses = board.kind !== "" || JSON.stringify(board.tiles).includes("$device");
    if (!free && (!uses || fits.length < 2)) return html`<p class="muted">${board.note || detail.name}</p>`;
    return html`<div class="subjects">
      ${free ? html`<label>${msg("Site")} <select aria-label=${msg("Site of the board")} @change=${this.onSite}>${renderOptions(list.map(({ site, name }) => [site, name] as const), detail.site)}</select></label>` : nothing}
      ${uses && fits.length > 1 ? html`<label>${msg("Device")} <select aria-label=${msg("Device of the board")} @change=${this.onDevice}>${renderOptions(fits.map(({ id, name }) => [id, name] as const), device?.id ?? "")}</select></label>` : nothing}
    </div>`;
  }

  private renderKioskBar(): TemplateResult {
    const lost = this.link.state !== "open";
    return html`${lost ? html`<t-banner kind="bad">${msg("No connection to the hub. What you see is old.")}</t-banner>` : nothing}
      <div class="leave"><t-button @click=${this.leaveKiosk}>${msg("Leave full screen")}</t-button></div>`;
  }

  // ── arranging ───────────────────────────────────────────────────────────────────────────

  private renderArrangeBar(board: BoardShape, detail: SiteShape): TemplateResult {
    const { draft } = this;
    return html`<section class="arrange" aria-label=${msg("Arrange the board")} data-turn=${this.draftKey}>
      <t-board-form .board=${board} .detail=${detail} @t-board=${this.onBoard}></t-board-form>
      <t-choice label=${msg("Layout for")} .options=${GRIDS} .chosen=${this.grid} @t-choose=${this.onGrid}></t-choice>
      <t-button @click=${this.onAddTile}>${msg("Add a tile…")}</t-button>
      <t-button kind="quiet" ?disabled=${draft?.canUndo !== true} @click=${this.undo}>${msg("Undo")}</t-button>
      <t-button kind="quiet" ?disabled=${draft?.canRedo !== true} @click=${this.redo}>${msg("Redo")}</t-button>
      <t-button kind="primary" ?busy=${this.action.busy} @click=${this.save}>${msg("Save")}</t-button>
      <t-button @click=${this.cancelArranging}>${draft?.isChanged === true ? msg("Discard") : msg("Done")}</t-button>
    </section>`;
  }

  private renderDialogs(board: BoardShape, detail: SiteShape): TemplateResult {
    const tile = board.tiles.find(({ id }) => id === this.settingsOf) ?? null;
    const { row } = this;
    const person = this.session.store?.person;
    return html`<t-dialog heading=${msg("Add a tile")} ?open=${this.open === "add"} @t-close=${this.onDialogClose}>
        ${this.open === "add" ? html`<t-tile-picker @t-choose=${this.onAdd}></t-tile-picker>` : nothing}
        <t-button slot="actions" @click=${this.onDialogClose}>${msg("Cancel")}</t-button>
      </t-dialog>
      <t-dialog heading=${msg(str`Settings: ${boardTileEntry(tile?.type ?? "")?.title ?? msg("Tile")}`)} ?open=${tile !== null && this.draft !== null} @t-close=${this.onSettingsClose}>
        ${tile === null ? nothing : html`<t-tile-form .tile=${tile} .subjects=${{ detail, device: this.device(board, detail) }} .extensions=${this.tiles.value?.tiles ?? []} @t-tile=${this.onTile}></t-tile-form>`}
        <t-button slot="actions" kind="primary" @click=${this.onSettingsClose}>${msg("Done")}</t-button>
      </t-dialog>
      <t-dialog heading=${msg("Versions")} ?open=${this.open === "versions"} @t-close=${this.onDialogClose}>
        ${this.open === "versions" ? html`<t-board-versions .row=${row} .zone=${detail.zone} @t-changed=${this.onBoardChanged}></t-board-versions>` : nothing}
        <t-button slot="actions" @click=${this.onDialogClose}>${msg("Close")}</t-button>
      </t-dialog>
      <t-dialog heading=${msg("Who sees this board")} ?open=${this.open === "share"} @t-close=${this.onDialogClose}>
        ${this.open === "share" ? html`<t-board-share .row=${row} .ownRole=${person?.role ?? ""} ?admin=${person?.admin ?? false} @t-changed=${this.onBoardChanged}></t-board-share>` : nothing}
        <t-button slot="actions" @click=${this.onDialogClose}>${msg("Close")}</t-button>
      </t-dialog>
      ${renderQuestion(this.removing, ({ name }) => ({ heading: msg(str`Remove ${name}?`), action: msg("Remove it"), text: msg("It goes with all its versions, for everybody. That cannot be taken back.") }))}`;
  }

  private redrawDraft(): void {
    this.draftKey += 1;
  }

  private readonly beginArranging = (): void => {
    const board = this.keptBoard;
    if (board === null) return;
    this.action.clear();
    this.grid = this.narrow ? "phone" : "desktop";
    this.draft = new BoardDraft(board);
    if (this.query.arrange) this.router.store?.replace(withQuery(boardPath(this.key), writeBoardQuery(this.query)));
  };

  private readonly cancelArranging = (): void => {
    this.draft = null;
    this.settingsOf = "";
  };

  private readonly undo = (): void => {
    this.draft?.undo();
    this.redrawDraft();
  };

  private readonly redo = (): void => {
    this.draft?.redo();
    this.redrawDraft();
  };

  private readonly onBoard = (event: CustomEvent<Partial<BoardShape>>): void => {
    this.draft?.change(event.detail, "name" in event.detail);
    this.redrawDraft();
  };

  private readonly onGrid = (event: CustomEvent<string>): void => {
    this.grid = event.detail === "phone" ? "phone" : "desktop";
  };

  private readonly onArrange = (event: CustomEvent<readonly GridItem[]>): void => {
    this.draft?.arrange(event.detail, this.grid);
    this.redrawDraft();
  };

  private readonly onSettings = (event: CustomEvent<string>): void => {
    this.settingsOf = event.detail;
  };

  private readonly onRemove = (event: CustomEvent<string>): void => {
    this.draft?.removeTile(event.detail);
    this.redrawDraft();
  };

  private readonly onTile = (event: CustomEvent<BoardTileShape>): void => {
    this.draft?.changeTile(event.detail);
    this.redrawDraft();
  };

  private readonly onAdd = (event: CustomEvent<string>): void => {
    const added = this.draft?.addTile(event.detail) ?? "";
    this.open = "";
    // What it shows is asked at once, where it can be asked.
    this.settingsOf = (boardTileEntry(event.detail)?.settings.length ?? 0) > 0 ? added : "";
    this.redrawDraft();
  };

  private readonly onVersions = (): void => {
    this.open = "versions";
  };

  private readonly onShare = (): void => {
    this.open = "share";
  };

  private readonly onAddTile = (): void => {
    this.open = "add";
  };

  private readonly onDialogClose = (): void => {
    this.open = "";
  };

  private readonly onSettingsClose = (): void => {
    this.settingsOf = "";
  };

  private readonly onBoardChanged = (): void => {
    this.open = "";
    this.kept.invalidate();
  };

  private readonly save = async (): Promise<void> => {
    const { draft, row } = this;
    if (draft === null || row === null) return;
    const board = draft.board;
    const done = await this.action.run(msg("save the board"), () => new BoardsApi(this.api).saveBoard(row.key, board, row.number), msg("Saved."));
    if (!done) return;
    this.draft = null;
    this.kept.invalidate();
  };

  private readonly saveCopy = async (): Promise<void> => {
    const board = this.keptBoard;
    if (board === null) return;
    let key = "";
    const name = readTemplateKey(this.key) === null ? msg(str`Copy of ${board.name}`).slice(0, 100) : board.name;
    const done = await this.action.run(msg("save a copy"), async () => {
      ({ key } = await new BoardsApi(this.api).addBoard({ ...board, name }, msg(str`copy of ${board.name}`).slice(0, 200)));
    });
    if (done) this.router.store?.navigate(`${boardPath(key)}?arrange=1`);
  };

  private async removeBoard(row: BoardRow, action: ActionController): Promise<boolean> {
    const done = await action.run(msg("remove the board"), () => new BoardsApi(this.api).removeBoard(row.key));
    if (done) this.router.store?.navigate("/boards");
    return done;
  }

  private readonly exportFile = async (): Promise<void> => {
    const board = this.keptBoard;
    if (board === null) return;
    await this.action.run(msg("export the board"), async () => {
      const text = await new BoardsApi(this.api).writeText(board);
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([text], { type: "text/yaml" }));
      link.download = `${board.name.toLowerCase().replaceAll(/[^a-z0-9]+/g, "-").replaceAll(/^-|-$/g, "") || "board"}.yaml`;
      link.click();
      URL.revokeObjectURL(link.href);
    });
  };

  // ── what it is looked at with, and the full screen ──────────────────────────────────────

  private replaceQuery(change: Partial<ReturnType<typeof readBoardQuery>>): void {
    this.router.store?.replace(withQuery(boardPath(this.key), writeBoardQuery({ ...this.query, ...change })));
  }

  private readonly onSite = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.replaceQuery({ site: event.target.value, device: "" });
  };

  private readonly onDevice = (event: Event): void => {
    if (event.target instanceof HTMLSelectElement) this.replaceQuery({ device: event.target.value });
  };

  private readonly fillScreen = (): void => {
    this.replaceQuery({ kiosk: true });
    // In full screen the browser keeps Escape for itself, and where somebody drives Escape is STOP.
    const drives = this.board?.tiles.some(({ type }) => boardTileEntry(type)?.rests === true) === true;
    if (!drives) document.documentElement.requestFullscreen().catch(() => undefined);
  };

  private readonly leaveKiosk = (): void => {
    this.replaceQuery({ kiosk: false, cycle: [] });
    if (document.fullscreenElement !== null) void document.exitFullscreen();
  };

  private readonly onFullScreenChange = (): void => {
    if (document.fullscreenElement === null && this.kiosk) this.replaceQuery({ kiosk: false, cycle: [] });
  };

  /** In a kiosk one board follows the other. */
  private followCycle(): void {
    const { key, query } = this;
    const wanted = query.kiosk ? nextInCycle(key, query.cycle) : "";
    const turn = wanted === "" ? "" : `${key} ${wanted} ${String(query.seconds)}`;
    if (turn === this.cycled) return;
    this.cycled = turn;
    clearTimeout(this.cycling);
    if (wanted === "") return;
    this.cycling = setTimeout(() => {
      this.router.store?.replace(withQuery(boardPath(wanted), writeBoardQuery({ ...query, device: "" })));
    }, query.seconds * 1000);
  }

  private readonly onWidth = (): void => {
    this.narrow = this.width.matches;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-board": PageBoard;
  }
}
