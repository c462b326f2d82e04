/** What each signal takes, as a table that can be sorted and filtered. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { base } from "../../elements/base/base-style.js";
import { renderOptions } from "../../elements/forms/form-parts.js";
import { control } from "../../elements/forms/input-style.js";
import { styled } from "../../elements/base/style-directive.js";
import { renderTable, tables, type Sorting, type TableColumn } from "../../elements/layout/data-table.js";
import { formatBytes } from "../../format/bytes.js";
import { formatNumber } from "../../format/number.js";
import { formatDate } from "../../format/time.js";
import { sitePath } from "../../state/router.js";
import { filterSignals, FIRST_SORTING, sortSignals, toggleSorting, type SignalUse, type SortKey } from "./signal-usage.js";
import { storageTableStyle } from "./storage-style.js";
import { keepText } from "./storage-text.js";
import "../../elements/forms/button.js";

/** More rows are drawn when they are asked for. */
const MANY = 200;

@customElement("t-storage-table")
export class StorageTable extends LitElement {
  static override styles = [base, control, tables, storageTableStyle];

  @property({ attribute: false }) signals: readonly SignalUse[] = [];
  @property({ attribute: false }) zoneOf: (site: string) => string = () => "UTC";

  @state() private sorting: Sorting<SortKey> = FIRST_SORTING;
  @state() private filter = "";
  @state() private all = false;

  override render(): TemplateResult {
    const fits = sortSignals(filterSignals(this.signals, this.filter), this.sorting);
    const shown = this.all ? fits : fits.slice(0, MANY);
    const columns = this.columns();
    return html`<div class="tools">
        <input type="search" placeholder=${msg("Filter", { id: "filter.verb" })} aria-label=${msg("Filter signals")} @input=${this.onInput} />
        <label class="sort"
          >${msg("Sort by")}
          <select @change=${this.onChange}>
            ${renderOptions(columns.map(({ sort = "", title }) => [sort, title]), this.sorting.by)}
          </select>
          <t-button @click=${this.onSortChange}>${this.sorting.down ? msg("Falling") : msg("Rising")}</t-button>
        </label>
      </div>
      ${renderTable({
        label: msg("What each signal takes"),
        columns,
        rows: shown,
        key: ({ site, address }) => `${site}\n${address}`,
        sorting: this.sorting,
        onSort: this.sortBy,
      })}
      ${fits.length === 0 ? html`<p class="muted small">${msg("No signal is called like this.")}</p>` : nothing}
      <p class="muted small">${msg("The newest samples of each signal, up to some ten thousand, are in no block yet and not in it.")}</p>
      ${fits.length > shown.length ? html`<t-button @click=${this.showMore}>${msg(str`Show all ${fits.length} signals`)}</t-button>` : nothing}`;
  }

  private columns(): readonly TableColumn<SignalUse, SortKey>[] {
    const most = Math.max(1, ...this.signals.map(({ bytes }) => bytes));
    return [
      { title: msg("Signal"), name: "who", sort: "name", cell: renderSignal },
      { title: msg("Size"), name: "size", sort: "bytes", cell: ({ bytes }) => renderSize(bytes, most) },
      { title: msg("Per day"), name: "number", titled: true, sort: "day", cell: ({ dayBytes }) => formatBytes(dayBytes) },
      { title: msg("Samples"), name: "number", titled: true, sort: "samples", cell: ({ samples }) => formatNumber(samples, 0) },
      { title: msg("From – to"), name: "when", titled: true, sort: "first", cell: (use) => this.spanText(use) },
      { title: msg("Kept"), titled: true, sort: "keep", cell: ({ keepDays }) => keepText(keepDays) },
    ];
  }

  private spanText({ site, firstUs, lastUs }: SignalUse): string {
    const zone = this.zoneOf(site);
    const first = formatDate(firstUs, zone);
    const last = formatDate(lastUs, zone);
    return first === last ? first : `${first} – ${last}`;
  }

  private readonly onInput = (event: Event): void => {
    if (event.target instanceof HTMLInputElement) this.filter = event.target.value;
  };

  private readonly onChange = (event: Event): void => {
    const key = event.target instanceof HTMLSelectElement ? event.target.value : "";
    const sort = this.columns().find((column) => column.sort === key)?.sort;
    if (sort !== undefined && sort !== this.sorting.by) this.sortBy(sort);
  };

  private readonly onSortChange = (): void => {
    this.sorting = { ...this.sorting, down: !this.sorting.down };
  };

  private readonly sortBy = (by: SortKey): void => {
    this.sorting = toggleSorting(this.sorting, by);
  };

  private readonly showMore = (): void => {
    this.all = true;
  };
}

function renderSignal(use: SignalUse): TemplateResult {
  return html`<a href=${historyOf(use)}>${use.name}</a>
    <span class="muted small">${use.site} · ${use.address}${use.described ? "" : msg(", no longer in the description")}</span>`;
}

/** With a bar beside it: how much it is of the largest. */
function renderSize(bytes: number, most: number): TemplateResult {
  const share = { "inline-size": `${String((100 * bytes) / most)}%` };
  return html`<span class="share" aria-hidden="true"><i ${styled(share)}></i></span><span>${formatBytes(bytes)}</span>`;
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
