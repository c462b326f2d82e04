/** What each signal takes, as a table that can be sorted and filtered. */

import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../../elements/base/base-style.js";
import { control } from "../../elements/forms/input-style.js";
import { styled } from "../../elements/base/style-directive.js";
import { formatBytes } from "../../format/bytes.js";
import { formatNumber } from "../../format/number.js";
import { formatDate } from "../../format/time.js";
import { sitePath } from "../../state/router.js";
import { filterSignals, FIRST_SORTING, sortSignals, toggleSorting, type SignalUse, type SortKey, type Sorting } from "./signal-usage.js";
import { storageTableStyle } from "./storage-style.js";
import { keepText } from "./storage-text.js";
import "../../elements/forms/button.js";

const COLUMNS: readonly { readonly key: SortKey; readonly title: string; readonly number?: boolean }[] = [
  { key: "name", title: "Signal" },
  { key: "bytes", title: "Size" },
  { key: "day", title: "Per day", number: true },
  { key: "samples", title: "Samples", number: true },
  { key: "first", title: "From – to" },
  { key: "keep", title: "Kept" },
];
/** More rows are drawn when they are asked for. */
const MANY = 200;

@customElement("t-storage-table")
export class StorageTable extends LitElement {
  static override styles = [base, control, storageTableStyle];

  @property({ attribute: false }) signals: readonly SignalUse[] = [];
  @property({ attribute: false }) zoneOf: (site: string) => string = () => "UTC";

  @state() private sorting: Sorting = FIRST_SORTING;
  @state() private filter = "";
  @state() private all = false;

  override render(): TemplateResult {
    const fits = sortSignals(filterSignals(this.signals, this.filter), this.sorting);
    const shown = this.all ? fits : fits.slice(0, MANY);
    const most = Math.max(1, ...this.signals.map(({ bytes }) => bytes));
    return html`<div class="tools">
        <input type="search" placeholder="Filter" aria-label="Filter signals" @input=${this.onInput} />
        <label class="sort"
          >Sort by
          <select @change=${this.onChange}>
            ${map(COLUMNS, ({ key, title }) => html`<option value=${key} .selected=${key === this.sorting.by}>${title}</option>`)}
          </select>
          <t-button @click=${this.onSortChange}>${this.sorting.down ? "Falling" : "Rising"}</t-button>
        </label>
      </div>
      <div class="table" role="table" aria-label="What each signal takes">
        <div class="row titles" role="row">${map(COLUMNS, (column) => this.renderHeading(column))}</div>
        ${repeat(
          shown,
          ({ site, address }) => `${site}\n${address}`,
          (use) => this.renderRow(use, most),
        )}
      </div>
      ${fits.length === 0 ? html`<p class="small">No signal is called like this.</p>` : nothing}
      <p class="small">The newest samples of each signal, up to some ten thousand, are in no block yet and not in it.</p>
      ${fits.length > shown.length ? html`<t-button @click=${this.showMore}>Show all ${fits.length} signals</t-button>` : nothing}`;
  }

  private renderHeading({ key, title, number = false }: (typeof COLUMNS)[number]): TemplateResult {
    const { by, down } = this.sorting;
    const sort = key !== by ? nothing : down ? "descending" : "ascending";
    return html`<span role="columnheader" class=${number ? "number" : ""} aria-sort=${sort}
      ><button type="button" data-key=${key} @click=${this.onPress}>
        ${title}<span aria-hidden="true">${key !== by ? "" : down ? "↓" : "↑"}</span>
      </button></span
    >`;
  }

  private renderRow(use: SignalUse, most: number): TemplateResult {
    const zone = this.zoneOf(use.site);
    const first = formatDate(use.firstUs, zone);
    const last = formatDate(use.lastUs, zone);
    const share = { "inline-size": `${String((100 * use.bytes) / most)}%` };
    return html`<div class="row" role="row">
      <span role="cell" class="who"
        ><a href=${historyOf(use)}>${use.name}</a>
        <span class="small">${use.site} · ${use.address}${use.described ? "" : ", no longer in the description"}</span></span
      >
      <span role="cell" class="size"
        ><span class="share" aria-hidden="true"><i ${styled(share)}></i></span><span>${formatBytes(use.bytes)}</span></span
      >
      <span role="cell" class="number" data-title="Per day">${formatBytes(use.dayBytes)}</span>
      <span role="cell" class="number" data-title="Samples">${formatNumber(use.samples, 0)}</span>
      <span role="cell" class="when" data-title="From – to">${first === last ? first : `${first} – ${last}`}</span>
      <span role="cell" data-title="Kept">${keepText(use.keepDays)}</span>
    </div>`;
  }

  private readonly onInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.filter = event.target.value;
  };

  private readonly onChange = (event: Event): void => {
    const key = event.target instanceof HTMLSelectElement ? event.target.value : "";
    const column = COLUMNS.find((column) => column.key === key);
    if (column !== undefined && column.key !== this.sorting.by) this.sorting = toggleSorting(this.sorting, column.key);
  };

  private readonly onSortChange = (): void => {
    this.sorting = { ...this.sorting, down: !this.sorting.down };
  };

  private readonly onPress = (event: Event): void => {
    const key = event.currentTarget instanceof HTMLElement ? event.currentTarget.dataset["key"] : "";
    const column = COLUMNS.find((column) => column.key === key);
    if (column !== undefined) this.sorting = toggleSorting(this.sorting, column.key);
  };

  private readonly showMore = (): void => {
    this.all = true;
  };
}

/** All that is kept of a signal. */
function historyOf({ site, channels, firstUs, lastUs }: SignalUse): string {
  const query = new URLSearchParams(channels.map((channel) => ["c", channel]));
  query.set("from", String(firstUs));
  query.set("to", String(Math.max(lastUs, firstUs + 1_000_000)));
  return `${sitePath(site, "history")}?${query.toString().replaceAll("%2F", "/")}`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-storage-table": StorageTable;
  }
}
