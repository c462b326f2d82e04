/** People of this hub: who may sign in, with which role, and everything an admin does about it. */

import { consume } from "@lit/context";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import type { PersonRow, RoleRow } from "../../wire/admin-types.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import type { NewPerson } from "./person-form.js";
import { renderLoadError, renderLoadingNote } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../admin-tabs.js";
import "./person-form.js";
import "./person-row.js";

interface LoadedPeople {
  readonly people: readonly PersonRow[];
  readonly roles: readonly RoleRow[];
}

@customElement("t-page-people")
export class PagePeople extends LitElement {
  static override styles = [
    base,
    sheets,
    css`
      .sheet {
        gap: 0;
        padding-block: var(--t-space-2);
      }
      ul {
        margin: 0;
        padding: 0;
        list-style: none;
      }
      li + li {
        border-block-start: 1px solid var(--t-line);
      }
    `,
  ];

  @state() private adding = false;
  @state() private open = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly everyone = new LoadController<LoadedPeople>(this);
  private readonly action = new ActionController(this);

  override willUpdate(): void {
    this.everyone.load("everyone", async () => {
      const api = new AdminApi(this.api);
      const [people, roles] = await Promise.all([api.people(), api.roles()]);
      return { people, roles };
    });
  }

  override render(): TemplateResult {
    const everyone = this.everyone.value;
    return html`<t-admin-tabs page="people"></t-admin-tabs>
      <div class="head">
        <div>
          <h1>People</h1>
          ${everyone === undefined ? nothing : html`<p class="muted">${peopleSummary(everyone.people)}</p>`}
        </div>
        ${this.adding || everyone === undefined
          ? nothing
          : html`<t-button kind="primary" @click=${this.openForm}>Add a person</t-button>`}
      </div>
      <p class="visually-hidden" role="status">${this.action.doneText}</p>
      ${this.adding && everyone !== undefined
        ? html`<t-person-form
            class="sheet"
            .roles=${everyone.roles}
            .problem=${this.action.problem}
            ?busy=${this.action.busy}
            @t-add=${this.addPerson}
            @t-cancel=${this.closeForm}
          ></t-person-form>`
        : nothing}
      ${renderLoadError(this.everyone.result, "the list of people", this.retry)} ${everyone === undefined ? renderLoadingNote(this.everyone.result, "Loading the people") : this.renderList(everyone)}`;
  }

  private renderList({ people, roles }: LoadedPeople): TemplateResult {
    const me = this.session.store?.person?.name ?? "";
    return html`<ul class="sheet">
      ${repeat(
        people,
        (row) => row.id,
        (row) => html`<li>
          <t-person-row
            .row=${row}
            .roles=${roles}
            .zone=${this.sites.store?.zone ?? "UTC"}
            ?self=${row.name === me}
            ?open=${row.id === this.open}
            @t-toggle=${this.detailsToggler(row)}
            @t-changed=${this.retry}
          ></t-person-row>
        </li>`,
      )}
    </ul>`;
  }

  private detailsToggler(row: PersonRow): () => void {
    return () => {
      this.open = this.open === row.id ? "" : row.id;
    };
  }

  private readonly openForm = (): void => {
    this.adding = true;
    this.action.clear();
  };

  private readonly closeForm = (): void => {
    this.adding = false;
    this.action.clear();
  };

  private readonly retry = (): void => {
    this.everyone.invalidate();
  };

  private readonly addPerson = (event: CustomEvent<NewPerson>): void => {
    const { name, password, role } = event.detail;
    const api = new AdminApi(this.api);
    void this.action.run(`add ${name}`, () => api.addPerson(name, password, role), `${name} is added.`).then((done) => {
      if (!done) return;
      this.adding = false;
      this.retry();
    });
  };
}

function peopleSummary(people: readonly PersonRow[]): string {
  const off = people.filter((row) => row.disabled).length;
  const here = people.filter((row) => row.sessions > 0).length;
  const many = `${String(people.length)} ${people.length === 1 ? "person" : "people"}`;
  return `${many}, ${String(here)} signed in${off === 0 ? "" : `, ${String(off)} disabled`}`;
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-people": PagePeople;
  }
}
