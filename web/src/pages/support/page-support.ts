/** One file for whoever helps: made at the hub, downloaded, handed on by a person. */

import { consume } from "@lit/context";
import { msg, str } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { map } from "lit/directives/map.js";
import { ActionController } from "../../controllers/action.js";
import { base } from "../../elements/base/base-style.js";
import { renderAdvice } from "../../elements/feedback/load-state.js";
import { renderPageHead } from "../../elements/layout/page-head.js";
import { sheets } from "../../elements/layout/page-sections.js";
import { formatBytes } from "../../format/bytes.js";
import { apiContext } from "../../state/contexts.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { supportStyle } from "./support-style.js";
import "../../elements/forms/button.js";
import "../admin-tabs.js";

const FILE = "talaia-support.zip";
/** What is in it, in the order of the file. */
const PARTS: readonly (readonly [string, string])[] = [
  [msg("Versions"), msg("Talaia, Python, the system, every installed package")],
  [msg("Machine"), msg("what talaia doctor finds: ports, clock, disk, certificates, ROS")],
  [msg("Programs"), msg("Talaia's programs that run, and their memory")],
  [msg("Settings"), msg("variables and settings files of this hub")],
  [msg("Database"), msg("kind, size and the number of rows of each table; no content")],
  [msg("Gateways"), msg("their versions, and when they were seen last")],
  [msg("Descriptions"), msg("of all sites, without comments, and what is wrong in them")],
  [msg("Logs"), msg("the last lines of each log that the hub's machine keeps")],
];

@customElement("t-page-support")
export class PageSupport extends LitElement {
  static override styles = [base, sheets, supportStyle];

  /** Where the file that was made last lies in this browser; empty before. */
  @state() private url = "";
  @state() private size = 0;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly action = new ActionController(this);

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    this.forget();
  }

  override render(): TemplateResult {
    return html`<t-admin-tabs page="support"></t-admin-tabs>
      ${renderPageHead(msg("Support"))}
      <section class="sheet" aria-labelledby="bundle">
        <h2 id="bundle">${msg("Support bundle")}</h2>
        <p>${msg("One ZIP file with what somebody who helps you needs to know of this hub. It goes nowhere by itself: look through it, then hand it on.")}</p>
        <div class="actions">
          <t-button kind="primary" ?busy=${this.action.busy} @click=${this.make}>${msg("Make a support bundle")}</t-button>
          ${this.url === "" ? nothing : html`<a download=${FILE} href=${this.url}>${msg("Download it again")}</a>`}
        </div>
        <p role="status">${this.action.busy ? msg("It takes up to a minute…") : this.url === "" ? "" : msg(str`${FILE}, ${formatBytes(this.size)}, is among your downloads.`)}</p>
        ${renderAdvice(this.action.problem)}
      </section>
      <section class="sheet" aria-labelledby="inside">
        <h2 id="inside">${msg("What is in it")}</h2>
        <dl>
          ${map(
            PARTS,
            ([name, what]) => html`<div>
              <dt>${name}</dt>
              <dd>${what}</dd>
            </div>`,
          )}
        </dl>
        <p>${msg(html`<strong>Masked</strong> (as <code>***</code>): keys, tokens and passwords, wherever they stand; arguments of programs; mail addresses; whatever looks drawn at random.`)}</p>
        <p>${msg(html`<strong>Not masked</strong>: names of sites, devices and signals, host names, network addresses. A password that somebody wrote into a device's name is known to nobody.`)}</p>
        <p>${msg(html`A gateway's own log lies on the robot's computer: <code>talaia support-bundle help.zip --site site.yaml</code> makes the same file there.`)}</p>
      </section>`;
  }

  private readonly make = async (): Promise<void> => {
    this.forget();
    let bytes = new ArrayBuffer(0);
    const made = await this.action.run(msg("make the support bundle"), async () => {
      bytes = await new AdminApi(this.api).supportBundle();
    });
    if (!made) return;
    this.url = URL.createObjectURL(new Blob([bytes], { type: "application/zip" }));
    this.size = bytes.byteLength;
    const link = document.createElement("a");
    link.href = this.url;
    link.download = FILE;
    link.click();
  };

  private forget(): void {
    if (this.url !== "") URL.revokeObjectURL(this.url);
    this.url = "";
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-page-support": PageSupport;
  }
}
