/** Roles: what each may do at every site and device. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { base, quietText } from "../../elements/base/base-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import { apiContext } from "../../state/contexts.js";
import type { DeviceSummary, RoleShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { changesOf, draftsOf, withLevelEdited, withExtraEdited, isChanged, matrixLines, updatedDrafts, type RoleChange, type RoleDraft, type MatrixLine } from "./permission-matrix.js";
import type { CellEdit, ExtraEdit } from "./role-matrix.js";
import { renderAdvice, renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../admin-tabs.js";
import "./role-dialog.js";
import "./role-factors.js";
import "./role-matrix.js";

interface LoadedRoles {
  readonly roles: readonly RoleShape[];
  readonly devices: readonly DeviceSummary[];
}

@customElement("t-page-roles")
export class PageRoles extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .bar {
        position: sticky;
        inset-block-end: 0;
        z-index: 5;
        display: grid;
        gap: var(--t-space-3);
        padding: var(--t-space-4);
        border: 2px solid var(--t-warn);
        border-radius: var(--t-radius);
        background: var(--t-surface);
        box-shadow: var(--t-shadow);
      }
      .bar ul {
        max-block-size: 9rem;
        overflow-y: auto;
        margin: 0;
        padding-inline-start: 1.2em;
      }
      .legend {
        ${quietText}
        max-inline-size: 60rem;
      }
      @media (max-width: 45rem) {
        .bar {
          inset-block-end: calc(4rem + env(safe-area-inset-bottom));
        }
      }
    `,
  ];

  @state() private drafts: readonly RoleDraft[] = [];
  /** The role in the dialog; null for none, a new one without id. */
  private readonly dialog = new OpenSubject<RoleShape | "new">(this);

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly given = new LoadController<LoadedRoles>(this);
  private readonly action = new ActionController(this);
  private lines: readonly MatrixLine[] = [];
  private drawn: LoadedRoles | undefined;

  override willUpdate(): void {
    this.given.load("roles", async () => {
      const [roles, devices] = await Promise.all([new AdminApi(this.api).roles(), this.api.devices()]);
      return { roles, devices };
    });
    const { result } = this.given;
    if (result.state !== "ready" || result.value === this.drawn) return;
    this.drawn = result.value;
    this.lines = matrixLines(result.value.devices, result.value.roles);
    this.drafts = updatedDrafts(this.drafts, result.value.roles);
  }

  override render(): TemplateResult {
    const changes = changesOf(this.drafts, this.lines);
    return html`<t-admin-tabs page="roles"></t-admin-tabs>
      ${renderPageHead(
        msg("Roles"),
        msg("What each role may do, for the whole hub, a site, or one device."),
        html`<t-button ?disabled=${this.drawn === undefined} @click=${this.dialog.opener("new")}>${msg("Make a role")}</t-button>`,
      )}
      ${renderLoaded(this.given, msg("the list of roles"), () => this.renderMatrix())}
      <p class="visually-hidden" role="status">${this.action.doneText}</p>
      ${changes.length === 0 ? nothing : this.renderBar(changes)}
      <t-role-dialog
        .edited=${this.dialog.subject === "new" ? null : this.dialog.subject}
        .roles=${this.drawn?.roles ?? []}
        ?open=${this.dialog.isOpen}
        @t-close=${this.dialog.close}
        @t-changed=${this.onRoleChanged}
      ></t-role-dialog>`;
  }

  private renderMatrix(): TemplateResult {
    return html`<t-role-matrix
        .lines=${this.lines}
        .drafts=${this.drafts}
        ?busy=${this.action.busy}
        @t-edit=${this.onCellEdit}
        @t-extra=${this.onExtraEdit}
        @t-role=${this.openRole}
      ></t-role-matrix>
      <p class="legend">
        ${msg(html`<strong>view</strong> sees values, pictures and history, and may STOP. <strong>use</strong> drives and commands besides. <strong>admin</strong> manages besides. <strong>–</strong> sees what is public only. <strong>tap</strong> has the robot’s raw topics, <strong>metrics</strong> lets Prometheus read figures of the signals that it sees, whatever else it may. <strong>request</strong> asks for observations for a proposal, <strong>approve</strong> lets them be observed, <strong>arm</strong> lets the night run by itself. A dashed cell has its right from a line above it.`)}
      </p>
      <t-role-factors class="sheet" .roles=${this.drawn?.roles ?? []} @t-changed=${this.given.invalidate}></t-role-factors>`;
  }

  private renderBar(changes: readonly RoleChange[]): TemplateResult {
    const { problem } = this.action;
    const roles = this.drafts.filter(isChanged).length;
    return html`<section class="bar" aria-label=${msg("Unsaved changes")}>
      <div class="head">
        <h2>${msg(str`${plural(changes.length, msg("1 change"), msg(str`${String(changes.length)} changes`))} in ${plural(roles, msg("1 role"), msg(str`${String(roles)} roles`))}, not saved yet`)}</h2>
        <div class="actions">
          <t-button ?disabled=${this.action.busy} @click=${this.discardChanges}>${msg("Undo all")}</t-button>
          <t-button kind="primary" ?busy=${this.action.busy} @click=${this.saveChanges}>${msg("Save")}</t-button>
        </div>
      </div>
      <ul>
        ${map(
          changes,
          ({ role, place, before, after }) =>
            html`<li>${msg(html`<strong>${role}</strong> on ${place}: ${before} → <strong>${after}</strong>`)}</li>`,
        )}
      </ul>
      ${renderAdvice(problem)}
    </section>`;
  }

  private readonly onCellEdit = (event: CustomEvent<CellEdit>): void => {
    const { role, line, level } = event.detail;
    this.action.clear();
    this.drafts = withLevelEdited(this.drafts, role, line, level);
  };

  private readonly onExtraEdit = (event: CustomEvent<ExtraEdit>): void => {
    const { role, line, right, given } = event.detail;
    this.action.clear();
    this.drafts = withExtraEdited(this.drafts, role, line, { right, given });
  };

  private readonly discardChanges = (): void => {
    this.action.clear();
    this.drafts = draftsOf(this.drawn?.roles ?? []);
  };

  private readonly saveChanges = (): void => {
    const changed = this.drafts.filter(isChanged);
    const api = new AdminApi(this.api);
    void this.action
      .run(
        msg("save all changes"),
        async () => {
          for (const { role, permissions } of changed) {
            await api.changeRole(role.id, role.name, permissions);
            // What is saved is no change any more, also when the next one fails.
            this.drafts = this.drafts.map((draft) =>
              draft.role.id === role.id ? { role: { ...role, permissions }, permissions } : draft,
            );
          }
        },
        msg("The roles are saved."),
      )
      .then((done) => {
        if (done) this.given.invalidate();
      });
  };

  private readonly openRole = (event: CustomEvent<string>): void => {
    const role = this.drawn?.roles.find(({ id }) => id === event.detail);
    if (role !== undefined) this.dialog.open(role);
  };

  private readonly onRoleChanged = (): void => {
    this.dialog.close();
    this.given.invalidate();
  };
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-roles": PageRoles;
  }
}
