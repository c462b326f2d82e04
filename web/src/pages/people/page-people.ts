/** People of this hub: who may sign in, with which role, and everything an admin does about it. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { css, html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { repeat } from "lit/directives/repeat.js";
import { ActionController } from "../../controllers/action.js";
import { LoadController } from "../../controllers/load.js";
import { OpenSubject } from "../../controllers/open-subject.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base, plainList } from "../../elements/base/base-style.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { plural } from "../../words/plural.js";
import { apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import type { PersonAsk, PersonShape, RoleShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { renderLoaded } from "../../elements/feedback/load-state.js";
import "../../elements/forms/button.js";
import "../admin-tabs.js";
import "./displays.js";
import "./person-form.js";
import "./person-row.js";

interface LoadedPeople {
  readonly people: readonly PersonShape[];
  readonly roles: readonly RoleShape[];
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
        ${plainList}
      }
      li + li {
        border-block-start: 1px solid var(--t-line);
      }
    `,
  ];

  @state() private open = "";

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);
  private readonly everyone = new LoadController<LoadedPeople>(this);
  private readonly action = new ActionController(this);
  private readonly form = new OpenSubject<"new">(this);

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
      ${renderPageHead(
        msg("People"),
        everyone === undefined ? nothing : peopleSummary(everyone.people),
        html`<t-button kind="primary" ?hidden=${this.form.isOpen || everyone === undefined} @click=${this.form.opener("new")}>${msg("Add a person")}</t-button>`,
      )}
      <p class="visually-hidden" role="status">${this.action.doneText}</p>
      ${this.form.isOpen && everyone !== undefined
        ? html`<t-person-form
            class="sheet"
            .roles=${everyone.roles}
            .problem=${this.action.problem}
            ?busy=${this.action.busy}
            @t-add=${this.addPerson}
            @t-cancel=${this.closeForm}
          ></t-person-form>`
        : nothing}
      ${renderLoaded(this.everyone, msg("the list of people"), (known) => this.renderList(known))}
      <t-displays></t-displays>`;
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
            @t-changed=${this.everyone.invalidate}
          ></t-person-row>
        </li>`,
      )}
    </ul>`;
  }

  private detailsToggler(row: PersonShape): () => void {
    return () => {
      this.open = this.open === row.id ? "" : row.id;
    };
  }

  private readonly closeForm = (): void => {
    this.form.close();
    this.action.clear();
  };

  private readonly addPerson = (event: CustomEvent<PersonAsk>): void => {
    const { name, password, role } = event.detail;
    const api = new AdminApi(this.api);
    void this.action.run(msg(str`add ${name}`), () => api.addPerson(name, password, role), msg(str`${name} is added.`)).then((done) => {
      if (done) this.form.close();
      this.everyone.invalidate();
    });
  };
}

function peopleSummary(people: readonly PersonShape[]): string {
  const off = people.filter((row) => row.disabled).length;
  const here = people.filter((row) => row.sessions > 0).length;
  const many = plural(people.length, msg(str`${String(people.length)} person`), msg(str`${String(people.length)} people`));
  return off === 0 ? msg(str`${many}, ${String(here)} signed in`) : msg(str`${many}, ${String(here)} signed in, ${String(off)} disabled`);
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-people": PagePeople;
  }
}
