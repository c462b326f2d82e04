/** The matrix of roles, to read at a glance and to edit in place. */

import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, property, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { repeat } from "lit/directives/repeat.js";
import { base } from "../../elements/base/base-style.js";
import { plural } from "../../words/plural.js";
import { EXTRA_RIGHT_NAMES, LEVELS, levelRank, type AccessLevel, type ExtraRight } from "../../state/rights.js";
import { cellOf, isFixed, lineKey, type ExtraCell, type RoleDraft, type MatrixLine } from "./permission-matrix.js";
import { matrixStyle } from "./role-matrix-style.js";
import "../../elements/forms/button.js";
import "../../elements/forms/choice.js";

export interface CellEdit {
  readonly role: string;
  readonly line: MatrixLine;
  readonly level: AccessLevel;
}

export interface ExtraEdit {
  readonly role: string;
  readonly line: MatrixLine;
  readonly right: ExtraRight;
  readonly given: boolean;
}

/**
 * @fires t-edit detail is the cell and its new level
 * @fires t-extra detail is the cell, and whether a right beside the levels holds there from now on
 * @fires t-role detail is the id of the role whose name or being is to be changed
 */
@customElement("t-role-matrix")
export class RoleMatrix extends LitElement {
  static override styles = [base, matrixStyle];

  @property({ attribute: false }) lines: readonly MatrixLine[] = [];
  @property({ attribute: false }) drafts: readonly RoleDraft[] = [];
  @property({ type: Boolean }) busy = false;
  /** The role that a narrow page shows. */
  @state() private chosen = "";

  override render(): TemplateResult {
    const shown = this.drafts.find(({ role }) => role.id === this.chosen) ?? this.drafts[0];
    const options = this.drafts.map(({ role }) => ({ id: role.id, label: role.name }));
    return html`<t-choice
        class="narrow"
        label=${msg("Role")}
        .options=${options}
        .chosen=${shown?.role.id ?? ""}
        @t-choose=${this.onChoose}
      ></t-choice>
      <div class="scroll" tabindex="0" role="region" aria-label=${msg("What each role may do")}>
        <table>
          <thead>
            <tr>
              <th scope="col" class="corner"><span class="visually-hidden">${msg("Site or device")}</span></th>
              ${repeat(
                this.drafts,
                ({ role }) => role.id,
                (draft) => this.renderHead(draft, draft === shown),
              )}
            </tr>
          </thead>
          <tbody>
            ${repeat(this.lines, lineKey, (line) => this.renderLine(line, shown))}
          </tbody>
        </table>
      </div>`;
  }

  private renderHead({ role }: RoleDraft, shown: boolean): TemplateResult {
    const people = plural(role.people, msg("1 person"), msg(str`${String(role.people)} people`));
    const edit = (): void => {
      this.dispatchEvent(new CustomEvent("t-role", { detail: role.id }));
    };
    return html`<th scope="col" class=${shown ? "shown" : ""}>
      <span class="role">${role.name}</span>
      <span class="people">${people}</span>
      ${role.seeded
        ? html`<span class="people">${msg("built in")}</span>`
        : html`<t-button kind="quiet" label=${msg(str`Rename or remove ${role.name}`)} @click=${edit}>${msg("Change…")}</t-button>`}
    </th>`;
  }

  private renderLine(line: MatrixLine, shown: RoleDraft | undefined): TemplateResult {
    return html`<tr class=${`d${String(line.depth)}`}>
      <th scope="row">
        <span class="place">${line.name}</span>
        ${line.depth === 2 && line.open ? html`<span class="public">${msg("public")}</span>` : nothing}
      </th>
      ${repeat(
        this.drafts,
        ({ role }) => role.id,
        (draft) => html`<td class=${draft === shown ? "shown" : ""}>${this.renderCell(draft, line)}</td>`,
      )}
    </tr>`;
  }

  private renderCell({ role, permissions }: RoleDraft, line: MatrixLine): TemplateResult {
    const { level, own, inherited, extras } = cellOf(permissions, line);
    const before = cellOf(role.permissions, line);
    const changed = own !== before.own;
    const classes = ["cell", level, own === "none" && level !== "none" ? "from" : "", changed ? "changed" : ""].join(" ");
    if (isFixed(role)) {
      return html`<span class=${classes} title=${msg("This role can do everything, always.")}>${level}</span>`;
    }
    // What a wider place gives cannot be taken away below it.
    const choices = LEVELS.filter((level) => levelRank(level) >= levelRank(inherited));
    const edit = (event: Event): void => {
      const select = event.target;
      if (!(select instanceof HTMLSelectElement)) return;
      const chosen = LEVELS.find((level) => level === select.value) ?? "none";
      this.dispatchEvent(
        new CustomEvent<CellEdit>("t-edit", { detail: { role: role.id, line, level: chosen } }),
      );
    };
    return html`<select
      class=${classes}
      aria-label=${changed ? msg(str`${role.name} on ${line.name}, was ${before.level}`) : msg(str`${role.name} on ${line.name}`)}
      title=${own === "none" && level !== "none" ? msg("Given by a line above") : ""}
      ?disabled=${this.busy}
      @change=${edit}
    >
      ${map(
        choices,
        (candidate) => html`<option value=${candidate} .selected=${candidate === level}>${candidate === "none" ? "–" : candidate}</option>`,
      )}
    </select>
    ${map(extras, (extra, at) => this.renderExtra(role.id, line, extra, before.extras[at]?.own === extra.own))}`;
  }

  private renderExtra(role: string, line: MatrixLine, { right, own, inherited }: ExtraCell, same: boolean): TemplateResult {
    const edit = (event: Event): void => {
      if (!(event.target instanceof HTMLInputElement)) return;
      const detail = { role, line, right, given: event.target.checked };
      this.dispatchEvent(new CustomEvent<ExtraEdit>("t-extra", { detail }));
    };
    return html`<label class=${same ? "extra" : "extra changed"} title=${inherited ? msg("Given by admin or a line above") : ""}>
      <input type="checkbox" .checked=${own || inherited} ?disabled=${this.busy || inherited} @change=${edit} />
      <span>${right}<span class="visually-hidden"> ${msg(str`${EXTRA_RIGHT_NAMES[right]} of ${line.name}`)}</span></span>
    </label>`;
  }

  private readonly onChoose = (event: CustomEvent<string>): void => {
    this.chosen = event.detail;
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-role-matrix": RoleMatrix;
  }
  interface GlobalEventHandlersEventMap {
    "t-edit": CustomEvent<CellEdit>;
    "t-extra": CustomEvent<ExtraEdit>;
    "t-role": CustomEvent<string>;
  }
}
