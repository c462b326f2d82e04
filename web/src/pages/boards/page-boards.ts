/** The boards that are open to the person: their own, shared ones, of descriptions, and those made of these. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, query, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { templatesOf, type TemplateBoard } from "../../boards/templates.js";
import { ActionController } from "../../controllers/action.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { LoadController } from "../../controllers/load.js";
import { base, plainList, raisedBox } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import type { BoardList, BoardReading, BoardRow, BoardShape, SiteShape } from "../../generated/api.js";
import { apiContext, routerContext, sessionContext, sitesContext } from "../../state/contexts.js";
import { boardPath } from "../../state/router.js";
import { BoardsApi } from "../../boards/boards-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/feedback/empty.js";
import "../../elements/feedback/problem.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";

const SHARES: Readonly<Record<BoardRow["share"], string>> = {
  own: msg("only you"), role: msg("one role"), view: msg("who may view the site"), public: msg("everybody"),
};

/** Read as a text before it is sent: nothing larger is a board. */
const MOST_BYTES = 262_144;

@customElement("t-page-boards")
export class PageBoards extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      ul {
        display: grid;
        grid-template-columns: repeat(auto-fill, minmax(min(20rem, 100%), 1fr));
        gap: var(--t-space-3);
        ${plainList}
      }
      section {
        display: grid;
        gap: var(--t-space-3);
      }
      li > a {
        display: grid;
        gap: var(--t-space-1);
        block-size: 100%;
        align-content: start;
        padding: var(--t-space-4);
        ${raisedBox}
        color: var(--t-text);
        text-decoration: none;
      }
      li > a:hover {
        border-color: var(--t-edge);
      }
      input[type="file"] {
        display: none;
      }
    `,
  ];

  @state() private reading: BoardReading | null = null;
  @query("input[type=file]") private readonly file!: HTMLInputElement;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly router = new ContextStoreController(this, routerContext);
  private readonly rows = new LoadController<BoardList>(this);
  private readonly details = new LoadController<readonly SiteShape[]>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    const sites = this.sites.store;
    const catalogues = (sites?.list ?? []).map(({ site }) => `${site} ${sites?.catalogueOf(site) ?? ""}`).join();
    this.rows.load(`boards ${catalogues}`, () => new BoardsApi(this.api).listBoards());
    if (sites === undefined || sites.list.length === 0) return;
    this.details.load(catalogues, async () => {
      const found = await Promise.allSettled(sites.list.map(({ site }) => sites.loadDetail(site)));
      return found.flatMap((result) => (result.status === "fulfilled" ? [result.value] : []));
    });
  }

  override render(): TemplateResult {
    const own = this.session.store?.person?.role !== "display";
    return html`${renderPageHead(
        msg("Boards"),
        msg("Tiles as you arrange them. Each shows what your role may see, whoever made the board."),
        own
          ? html`<div class="actions">
              <t-button ?busy=${this.action.busy} @click=${this.addEmpty}>${msg("New board")}</t-button>
              <t-button @click=${this.chooseFile}>${msg("Import…")}</t-button>
              <input type="file" accept=".yaml,.yml,text/yaml" aria-label=${msg("A board's file")} @change=${this.onFile} />
            </div>`
          : nothing,
      )}
      ${renderAdvice(this.action.problem)} ${this.renderReading()}
      ${renderLoaded(this.rows, msg("the boards"), ({ boards }) => this.renderBoards(boards))} ${this.renderTemplates()}`;
  }

  /** What is wrong with a file, and where. */
  private renderReading(): unknown {
    const { reading } = this;
    if (reading === null || reading.board !== null) return nothing;
    return html`<t-problem what=${msg(str`The file is no board: ${reading.where}: ${reading.problem}.`)} how=${reading.remedy || msg("Mend that place and import it again.")}></t-problem>`;
  }

  private renderBoards(boards: readonly BoardRow[]): unknown {
    const name = this.session.store?.person?.name ?? "";
    const mine = boards.filter(({ owner, described }) => !described && owner === name);
    const shared = boards.filter(({ owner, described }) => !described && owner !== name);
    const described = boards.filter((row) => row.described);
    return html`${this.renderSection(msg("Yours"), mine)} ${this.renderSection(msg("Shared with you"), shared)} ${this.renderSection(msg("Of sites"), described)}`;
  }

  private renderSection(title: string, rows: readonly BoardRow[]): unknown {
    if (rows.length === 0) return nothing;
    return html`<section aria-label=${title}>
      <h2>${title}</h2>
      <ul>
        ${map(
          rows,
          (row) => html`<li>
            <a href=${boardPath(row.key)}>
              <span class="name">${row.name}</span>
              <span class="facts">
                <span>${plural(row.tiles, msg("1 tile"), msg(str`${String(row.tiles)} tiles`))}</span>
                <span>${row.site === "" ? msg("any site") : (this.sites.store?.siteRow(row.site)?.name ?? row.site)}</span>
                ${row.described ? html`<span>${msg("in the site's description")}</span>` : html`<span>${row.share === "role" ? msg(str`of ${row.owner}, seen by the role ${row.role}`) : msg(str`of ${row.owner}, seen by ${SHARES[row.share]}`)}</span><span>${msg(html`version ${row.number}, <t-time short .us=${row.changed_us} .zone=${this.sites.store?.zone ?? "UTC"}></t-time>`)}</span>`}
              </span>
            </a>
          </li>`,
        )}
      </ul>
    </section>`;
  }

  private renderTemplates(): unknown {
    const details = this.details.value;
    if (this.sites.store?.status === "ready" && this.sites.store.list.length === 0) {
      return html`<t-empty heading=${msg("No site yet")} icon="unlinked"><p>${msg("Boards are made of a site's description as soon as its gateway has connected.")}</p></t-empty>`;
    }
    const templates = (details ?? []).flatMap((detail) => templatesOf(detail).map((template) => ({ detail, template })));
    if (templates.length === 0) return nothing;
    return html`<section aria-label=${msg("Made of the descriptions")}>
      <h2>${msg("Made of the descriptions")}</h2>
      <ul>${map(templates, ({ detail, template }) => this.renderTemplate(detail, template))}</ul>
    </section>`;
  }

  private renderTemplate(detail: SiteShape, { key, board }: TemplateBoard): TemplateResult {
    return html`<li>
      <a href=${boardPath(key)}>
        <span class="name">${board.name}</span>
        <span>${board.note}</span>
        <span class="facts"><span>${plural(board.tiles.length, msg("1 tile"), msg(str`${String(board.tiles.length)} tiles`))}</span><span>${detail.name}</span></span>
      </a>
    </li>`;
  }

  private readonly addEmpty = (): void => {
    void this.addBoard({ name: msg("New board"), note: "", site: "", kind: "", device: "", tiles: [] });
  };

  private async addBoard(board: BoardShape, note = ""): Promise<void> {
    let key = "";
    const done = await this.action.run(msg("make the board"), async () => {
      ({ key } = await new BoardsApi(this.api).addBoard(board, note));
    });
    if (done) this.router.store?.navigate(`${boardPath(key)}?arrange=1`);
  }

  /** Asked by a call: the compiler takes what was set before the wait for what is there. */
  private boardRead(): BoardShape | null {
    return this.reading?.board ?? null;
  }

  private readonly chooseFile = (): void => {
    this.file.value = "";
    this.file.click();
  };

  private readonly onFile = (): void => {
    const [file] = this.file.files ?? [];
    if (file !== undefined) void this.importFile(file);
  };

  private async importFile(file: File): Promise<void> {
    this.reading = null;
    if (file.size > MOST_BYTES) {
      this.reading = { board: null, where: file.name, problem: msg("it is longer than 256 KiB"), remedy: msg("Choose the file of a board.") };
      return;
    }
    const text = await file.text();
    await this.action.run(msg("read the file"), async () => {
      this.reading = await new BoardsApi(this.api).readText(text);
    });
    const board = this.boardRead();
    if (board !== null) await this.addBoard(board, msg(str`imported from ${file.name}`).slice(0, 200));
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-boards": PageBoards;
  }
}
