/** What is asked of a board besides arranging it: which tile to add, its versions, and who sees it. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type PropertyValues, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { base, plainList, quietText } from "../../elements/base/base-style.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import type { BoardRow, BoardVersionList } from "../../generated/api.js";
import { apiContext } from "../../state/contexts.js";
import { BOARD_TILES } from "../../tiles/board/board-catalog.js";
import { BoardsApi } from "../../boards/boards-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import "../../elements/base/icon.js";
import "../../elements/feedback/dialog.js";
import "../../elements/forms/button.js";
import "../../elements/values/time.js";

const dialogs = css`
  ul {
    display: grid;
    gap: var(--t-space-2);
    max-block-size: 60dvh;
    overflow: auto;
    ${plainList}
  }
  li {
    display: flex;
    flex-wrap: wrap;
    align-items: center;
    justify-content: space-between;
    gap: var(--t-space-1) var(--t-space-3);
    overflow-wrap: anywhere;
  }
  .facts {
    ${quietText}
  }
  p {
    ${quietText}
  }
`;

/** @fires t-choose the type of the tile to add */
@customElement("t-tile-picker")
export class TilePicker extends LitElement {
  static override styles = [
    base,
    dialogs,
    css`
      button {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: 0 var(--t-space-3);
        inline-size: 100%;
        padding: var(--t-space-2);
        border: 1px solid var(--t-line);
        border-radius: var(--t-radius-s);
        background: var(--t-surface);
        color: var(--t-text);
        font: inherit;
        text-align: start;
        cursor: pointer;
      }
      button:hover {
        background: var(--t-raised);
      }
      li {
        display: block;
      }
      strong,
      .facts {
        grid-column: 2;
      }
      t-icon {
        grid-row: span 2;
      }
    `,
  ];

  override render(): TemplateResult {
    return html`<ul>
      ${map(
        BOARD_TILES,
        ({ type, title, about, icon }) => html`<li>
          <button type="button" @click=${this.chooser(type)}>
            <t-icon name=${icon}></t-icon><strong>${title}</strong><span class="facts">${about}</span>
          </button>
        </li>`,
      )}
    </ul>`;
  }

  private chooser(type: string): () => void {
    return () => {
      this.dispatchEvent(new CustomEvent("t-choose", { detail: type }));
    };
  }
}

/**
 * @fires t-changed a version was restored
 */
@customElement("t-board-versions")
export class BoardVersions extends LitElement {
  static override styles = [base, dialogs];

  @property({ attribute: false }) row: BoardRow | null = null;
  @property() zone = "UTC";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly versions = new LoadController<BoardVersionList>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    const { row } = this;
    if (row !== null) this.versions.load(`${row.key} ${String(row.number)}`, () => new BoardsApi(this.api).listVersions(row.key));
  }

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    return html`${renderAdvice(this.action.problem)}
      ${renderLoaded(this.versions, msg("the versions"), ({ versions }) => html`<ul aria-label=${msg("Versions")}>
        ${map(
          versions,
          ({ number, time_us: time, who, note }) => html`<li>
            <div><strong>${msg(str`Version ${number}`)}</strong>${note === "" ? nothing : ` – ${note}`}<div class="facts"><t-time .us=${time} .zone=${this.zone}></t-time> ${who}</div></div>
            ${number === row.number
              ? html`<span class="facts">${msg("as it is now")}</span>`
              : row.may_change
                ? html`<t-button ?busy=${this.action.runningKey === String(number)} label=${msg(str`Restore version ${String(number)}`)} @click=${this.restorer(row, number)}>${msg("Restore")}</t-button>`
                : nothing}
          </li>`,
        )}
      </ul>`)}
      <p>${msg("A restored version becomes the newest one: nothing is lost.")}</p>`;
  }

  private restorer(row: BoardRow, number: number): () => void {
    return () => {
      const restore = (): Promise<unknown> => new BoardsApi(this.api).restoreVersion(row.key, number, row.number);
      void this.action.run(msg("restore the version"), restore, "", String(number)).then((done) => {
        if (done) this.dispatchEvent(new CustomEvent("t-changed"));
      });
    };
  }
}

const SHARES: readonly (readonly [share: BoardRow["share"], title: string, about: string])[] = [
  ["own", msg("Only you"), msg("Nobody else sees it; admins of the hub can.")],
  ["role", msg("Your role"), msg("Everybody who has your role sees it.")],
  ["view", msg("Who may view"), msg("Everybody with the right view at its site, and that site's displays.")],
  ["public", msg("Everybody"), msg("Everybody who is signed in, guests and every display. An admin decides that.")],
];

/** @fires t-changed it is shared with others now */
@customElement("t-board-share")
export class BoardShareForm extends LitElement {
  static override styles = [
    base,
    dialogs,
    css`
      fieldset {
        display: grid;
        gap: var(--t-space-2);
        margin: 0 0 var(--t-space-3);
        padding: 0;
        border: 0;
      }
      label {
        display: grid;
        grid-template-columns: auto minmax(0, 1fr);
        gap: 0 var(--t-space-2);
        align-items: baseline;
      }
      .facts {
        grid-column: 2;
      }
    `,
  ];

  @property({ attribute: false }) row: BoardRow | null = null;
  /** The person's own. */
  @property({ attribute: "own-role" }) ownRole = "";
  @property({ type: Boolean }) admin = false;
  @state() private chosen: BoardRow["share"] = "own";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override willUpdate(changed: PropertyValues<this>): void {
    if (changed.has("row") && this.row !== null) this.chosen = this.row.share;
  }

  override render(): TemplateResult | typeof nothing {
    const { row } = this;
    if (row === null) return nothing;
    return html`${renderAdvice(this.action.problem)}
      <fieldset>
        <legend class="visually-hidden">${msg("Who sees it")}</legend>
        ${map(
          SHARES,
          ([share, title, about]) => html`<label>
            <input type="radio" name="share" .value=${share} .checked=${share === this.chosen} ?disabled=${!this.mayChoose(row, share)} @change=${this.onChoose} />
            <strong>${title}</strong><span class="facts">${about}</span>
          </label>`,
        )}
      </fieldset>
      <p>${row.may_share ? msg("It opens no data: on each tile everybody sees what their own role may see.") : msg("It opens no data: on each tile everybody sees what their own role may see. To share takes the right use at the board's site.")}</p>
      <t-button kind="primary" ?busy=${this.action.busy} @click=${this.share}>${msg("Share it so")}</t-button>`;
  }

  private mayChoose(row: BoardRow, share: BoardRow["share"]): boolean {
    if (share === "public") return this.admin;
    return share === "own" || share === row.share || row.may_share;
  }

  private readonly onChoose = (event: Event): void => {
    const value = event.target instanceof HTMLInputElement ? event.target.value : "";
    this.chosen = SHARES.find(([share]) => share === value)?.[0] ?? "own";
  };

  private readonly share = async (): Promise<void> => {
    const { row } = this;
    if (row === null) return;
    const api = new BoardsApi(this.api);
    const { chosen } = this;
    const role = row.share === "role" && row.role !== "" ? row.role : this.ownRole;
    const done = await this.action.run(msg("share the board"), () =>
      chosen === "public" ? api.publishBoard(row.key) : api.shareBoard(row.key, { share: chosen, role: chosen === "role" ? role : "" }),
    );
    if (done) this.dispatchEvent(new CustomEvent("t-changed"));
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-tile-picker": TilePicker;
    "t-board-versions": BoardVersions;
    "t-board-share": BoardShareForm;
  }
}
