/** Samples as files to take away. */

import { msg } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { base, quietText } from "../../elements/base/base-style.js";
import type { ChoiceOption } from "../../elements/forms/choice.js";
import type { TimeSpan } from "../../series/time-window.js";
import { exportPath, type ExportQuery } from "../../wire/hub-api.js";
import { notesExportPath } from "../notes/notes-api.js";
import "../../elements/forms/choice.js";
import "../../elements/layout/menu.js";

const EXTENTS: readonly ChoiceOption[] = [
  { id: "window", label: msg("Window", { id: "window.shown" }) },
  { id: "drawn", label: msg("As drawn") },
  { id: "all", label: msg("Everything") },
];
const SAYS: Readonly<Record<string, string>> = {
  window: msg("Every sample of the chosen signals in the window that is shown."),
  drawn: msg("Only what the charts show: the least and the greatest of each pixel."),
  all: msg("Every sample of the chosen signals that is stored. This may be much."),
};
const FORMATS = [
  { format: "csv", name: "CSV", for: msg("spreadsheets") },
  { format: "parquet", name: "Parquet", for: "pandas, DuckDB" },
  { format: "arrow", name: "Arrow", for: "Arrow, Polars" },
] as const;

@customElement("t-export-menu")
export class ExportMenu extends LitElement {
  static override styles = [
    base,
    css`
      p {
        font-size: var(--t-size-s);
        font-weight: var(--t-weight);
      }
      @media (max-width: 45rem) {
        /* The panel hangs on what holds the menus: beside its own button there is no room. */
        t-menu {
          position: static;
        }
      }
      .files {
        display: grid;
        gap: var(--t-space-2);
      }
      a {
        display: flex;
        align-items: center;
        justify-content: space-between;
        min-block-size: var(--t-touch);
        padding-inline: var(--t-space-3);
        border: 1px solid var(--t-edge);
        border-radius: var(--t-radius-s);
        color: var(--t-text);
        font-weight: var(--t-weight-strong);
        text-decoration: none;
      }
      a:hover {
        background: var(--t-raised);
      }
      a span {
        ${quietText}
        font-weight: var(--t-weight);
      }
    `,
  ];

  @property() site = "";
  @property({ attribute: false }) channels: readonly string[] = [];
  @property({ attribute: false }) span: TimeSpan = { fromUs: 0, toUs: 1 };
  /** CSS pixels of the charts. */
  @property({ type: Number }) width = 1000;

  /** Why the hub would give no such file; it is asked before one is fetched that needs more than every hub has. */
  @property({ attribute: false }) refusal: (query: ExportQuery) => Promise<string> = () => Promise.resolve("");

  @state() private extent = "window";
  @state() private problem = "";

  override render(): TemplateResult {
    return html`<t-menu>
      <span slot="label">${msg("Export")}</span>
      ${this.channels.length === 0 ? html`<p>${msg("Choose a signal first.")}</p>` : this.renderFiles()}
      <div class="files"><a href=${notesExportPath(this.site, this.span)} download>${msg(html`Notes <span>CSV, of the window</span>`)}</a></div>
    </t-menu>`;
  }

  private renderFiles(): TemplateResult {
    return html`
      <t-choice label=${msg("How much")} .options=${EXTENTS} chosen=${this.extent} @t-choose=${this.onChoose}></t-choice>
      <p>${msg(html`${SAYS[this.extent]} One row for each time, one column for each signal; times in UTC.`)}</p>
      <div class="files">
        ${map(
          FORMATS,
          ({ format, name, for: use }) => html`<a
            href=${exportPath(this.site, this.query(format))}
            download
            @click=${format === "csv" ? nothing : this.onFile}
            data-format=${format}
            >${name} <span>${use}</span></a
          >`,
        )}
      </div>
      ${this.problem === "" ? nothing : html`<p role="alert">${this.problem}</p>`}
    `;
  }

  private query(format: ExportQuery["format"]): ExportQuery {
    const { channels } = this;
    if (this.extent === "all") return { channels, fromUs: 0, toUs: Date.now() * 1000, width: 0, format };
    return { channels, ...this.span, width: this.extent === "drawn" ? this.width : 0, format };
  }

  /** A download that is refused shows a browser's words alone, so the hub's are fetched before. */
  private readonly onFile = async (event: MouseEvent): Promise<void> => {
    const link = event.currentTarget as HTMLAnchorElement;
    // The second time it is this very function that presses it.
    if (link.dataset["asked"] === "yes") return;
    event.preventDefault();
    this.problem = await this.refusal(this.query(link.dataset["format"] as ExportQuery["format"]));
    if (this.problem !== "") return;
    link.dataset["asked"] = "yes";
    link.click();
    delete link.dataset["asked"];
  };

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.extent = event.detail;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-export-menu": ExportMenu;
  }
}
