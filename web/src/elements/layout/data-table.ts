/**
 * A table of many rows: a row of titles, sorted by a press on one. On a phone the titles go, and
 * each row folds into lines; where a page's columns stand then, its own style says.
 */

import { css, html, nothing, type TemplateResult } from "lit";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { panelBox, quietText } from "../base/base-style.js";

export interface Sorting<K extends string = string> {
  readonly by: K;
  readonly down: boolean;
}

export interface TableColumn<R, K extends string = string> {
  readonly title: string;
  /** The class of its cells. `number`: they end where the column ends. */
  readonly name?: string;
  readonly cell: (row: R) => unknown;
  /** Its cells say what their rows are about. */
  readonly heads?: boolean;
  /** Its title stands before its value where the titles are gone. */
  readonly titled?: boolean;
  /** By what a press on its title sorts; none: it does not. */
  readonly sort?: K;
}

interface DataTable<R, K extends string> {
  /** Its name for who hears the page. */
  readonly label: string;
  readonly columns: readonly TableColumn<R, K>[];
  readonly rows: readonly R[];
  readonly key: (row: R) => string;
  readonly busy?: boolean;
  readonly sorting?: Sorting<K>;
  readonly onSort?: (by: K) => void;
}

/** A page says how wide the columns are by `--t-columns`. */
export const tables = css`
  .table {
    ${panelBox}
    overflow: hidden;
  }
  .row {
    display: grid;
    grid-template-columns: var(--t-columns);
    gap: var(--t-space-1) var(--t-space-4);
    align-items: center;
    padding: var(--t-space-2) var(--t-space-4);
  }
  .row + .row {
    border-block-start: 1px solid var(--t-line);
  }
  .row > span {
    min-inline-size: 0;
    overflow-wrap: anywhere;
    font-variant-numeric: tabular-nums;
  }
  .titles {
    background: var(--t-raised);
    ${quietText}
    font-weight: var(--t-weight-strong);
  }
  .titles:has(button) {
    padding-block: 0;
  }
  .titles button {
    display: inline-flex;
    align-items: center;
    gap: var(--t-space-1);
    min-block-size: var(--t-touch);
    padding: 0;
    border: 0;
    background: none;
    color: inherit;
    font: inherit;
    cursor: pointer;
  }
  .titles button:hover,
  .titles [aria-sort] button {
    color: var(--t-text);
  }
  .number {
    text-align: end;
  }
  .titles .number {
    display: flex;
    justify-content: end;
  }
  @media (max-width: 60rem) {
    .titles {
      position: absolute;
      clip-path: inset(50%);
    }
    .row {
      grid-template-columns: minmax(0, 1fr) auto;
      padding-block: var(--t-space-3);
    }
    .number {
      text-align: start;
    }
    .row > span[data-title]::before {
      content: attr(data-title) " ";
      ${quietText}
    }
  }
`;

export function renderTable<R, K extends string>({ label, columns, rows, key, busy = false, sorting, onSort }: DataTable<R, K>): TemplateResult {
  return html`<div class="table" role="table" aria-label=${label} aria-busy=${busy}>
    <div class="row titles" role="row">${map(columns, (column) => renderTitle(column, sorting, onSort))}</div>
    ${repeat(
      rows,
      key,
      (row) => html`<div class="row" role="row">
        ${map(
          columns,
          ({ title, name = "", cell, heads = false, titled = false }) =>
            html`<span role=${heads ? "rowheader" : "cell"} class=${name} data-title=${titled ? title : nothing}>${cell(row)}</span>`,
        )}
      </div>`,
    )}
  </div>`;
}

function renderTitle<R, K extends string>({ title, name = "", sort }: TableColumn<R, K>, sorting?: Sorting<K>, onSort?: (by: K) => void): TemplateResult {
  if (sort === undefined) return html`<span role="columnheader" class=${name}>${title}</span>`;
  const down = sorting?.by === sort ? sorting.down : null;
  const onPress = (): void => onSort?.(sort);
  return html`<span role="columnheader" class=${name} aria-sort=${down === null ? nothing : down ? "descending" : "ascending"}
    ><button type="button" @click=${onPress}>
      ${title}<span aria-hidden="true">${down === null ? "" : down ? "↓" : "↑"}</span>
    </button></span
  >`;
}
