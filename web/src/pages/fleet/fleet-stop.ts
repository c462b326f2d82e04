/** STOP (software) for a group or for all, and how far it got at each robot. */

import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import type { GroupStopClient, GroupStopRow } from "../../controllers/drive/group-stop-client.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { StoreController } from "../../controllers/store-controller.js";
import { base } from "../../elements/base/base-style.js";
import { plural } from "../../words/plural.js";
import type { SiteSummary } from "../../generated/api.js";
import { sitesContext } from "../../state/contexts.js";
import { sitePath } from "../../state/router.js";
import { nameList } from "./group-preview.js";
import { groupRows } from "./group-rows-style.js";
import { stopSummary, stopWords } from "./group-stop-text.js";
import "../../elements/feedback/status.js";
import "../../elements/forms/button.js";
import "../../elements/stop/stop-button.js";

@customElement("t-fleet-stop")
export class FleetStop extends LitElement {
  static override styles = [
    base,
    groupRows,
    css`
      /* Its parts stand in the page's own grid, so that the button stays in reach while the page is long. */
      :host {
        display: contents;
        --t-word: 9rem;
      }
      t-stop-button {
        position: sticky;
        inset-block-start: calc(var(--t-header, 3.75rem) + var(--t-space-2));
        z-index: 10;
      }
    `,
  ];

  /** Sites that it is for. */
  @property({ attribute: false }) rows: readonly SiteSummary[] = [];
  /** They were chosen; else they are all that there are. */
  @property({ type: Boolean }) partial = false;
  @property({ attribute: false }) line: GroupStopClient | null = null;
  private readonly watched = new StoreController(this);
  private readonly sites = new ContextStoreController(this, sitesContext);

  override willUpdate(): void {
    this.watched.setStore(this.line);
  }

  override render(): TemplateResult {
    const able = this.rows.filter(({ stops }) => stops.length > 0);
    const without = this.rows.filter(({ stops }) => stops.length === 0);
    const pressed = this.line?.rows ?? [];
    const [name, many] = [able[0]?.name ?? "", String(able.length)];
    const whom = this.partial
      ? plural(able.length, msg(str`The one chosen robot that has it: ${name}`), msg(str`All ${many} chosen robots, at one press`))
      : plural(able.length, msg(str`The one robot that has it: ${name}`), msg(str`All ${many} robots, at one press`));
    const label = able.length === 0 ? msg("None of these has STOP") : whom;
    return html`
      <t-stop-button .label=${label} @t-stop=${this.pressStop}></t-stop-button>
      ${without.length === 0 ? nothing : html`<p class="note">${msg(str`Not stopped by it, since nothing of them is driven from here, or you may not view it: ${nameList(without.map(({ name }) => name))}.`)}</p>`}
      ${pressed.length === 0 ? html`<p class="note">${msg("No emergency stop: each robot needs a hardware stop. STOP is released robot by robot, on its own page.")}</p>` : this.renderPressed(pressed)}
    `;
  }

  /** STOP, from the button or the Escape key. */
  readonly pressStop = (): void => {
    const targets = this.rows.flatMap(({ site, stops }) => stops.map((device) => ({ site, device })));
    const away = this.rows.filter(({ online }) => !online).map(({ site }) => site);
    this.line?.pressStop(targets, away);
  };

  private renderPressed(rows: readonly GroupStopRow[]): TemplateResult {
    return html`
      <div class="head">
        <p role="status"><strong>${stopSummary(rows)}</strong></p>
        <t-button @click=${this.onForget}>${msg("Close the list")}</t-button>
      </div>
      <ul aria-label=${msg("How far STOP got")}>
        ${repeat(rows, ({ site, device }) => `${site}/${device}`, (row) => this.renderRow(row, rows))}
      </ul>
    `;
  }

  private renderRow(row: GroupStopRow, rows: readonly GroupStopRow[]): TemplateResult {
    const { kind, word, text } = stopWords(row);
    // Others may be chosen by now.
    const name = this.sites.store?.siteRow(row.site)?.name ?? row.site;
    const several = rows.some(({ site, device }) => site === row.site && device !== row.device);
    return html`<li>
      <span class="name">${name}${several ? `: ${row.device}` : ""}</span>
      <t-status kind=${kind} .word=${word}></t-status>
      <span class="text">${text}${row.who === "" ? "" : msg(str` Pressed by ${row.who}.`)}</span>
      <a href=${sitePath(row.site, "drive")} aria-label=${msg(str`Open ${name}`)}>${msg("Open", { id: "open.verb" })}</a>
    </li>`;
  }

  private readonly onForget = (): void => {
    this.line?.forgetRows();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-fleet-stop": FleetStop;
  }
}
