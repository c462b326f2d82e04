/** Tells admins on every page when there is soon no room for what comes. */

import { consume } from "@lit/context";
import { msg } from "@lit/localize";
import { html, LitElement, nothing, type TemplateResult } from "lit";
import { customElement, state } from "lit/decorators.js";
import { ContextStoreController } from "../../controllers/context-store.js";
import { base } from "../../elements/base/base-style.js";
import { apiContext, sessionContext, sitesContext } from "../../state/contexts.js";
import type { OutlookShape } from "../../generated/api.js";
import { AdminApi } from "../../wire/admin-api.js";
import type { HubApi } from "../../wire/hub-api.js";
import { warningOf } from "../storage/storage-text.js";
import "../../elements/feedback/banner.js";

const EVERY_MS = 5 * 60_000;

@customElement("t-storage-warning")
export class StorageWarning extends LitElement {
  static override styles = [base];

  @state() private outlook: OutlookShape | null = null;
  private timer: ReturnType<typeof setInterval> | undefined;
  private asked = false;

  @consume({ context: apiContext }) private readonly api!: HubApi;
  private readonly session = new ContextStoreController(this, sessionContext);
  private readonly sites = new ContextStoreController(this, sitesContext);

  override connectedCallback(): void {
    super.connectedCallback();
    this.timer = setInterval(() => void this.loadForecast(), EVERY_MS);
  }

  override disconnectedCallback(): void {
    super.disconnectedCallback();
    clearInterval(this.timer);
    this.asked = false;
  }

  override willUpdate(): void {
    if (!this.asked && this.isAdmin()) {
      this.asked = true;
      void this.loadForecast();
    }
  }

  override render(): TemplateResult | typeof nothing {
    if (this.outlook === null || !this.isAdmin()) return nothing;
    const warning = warningOf(this.outlook, this.sites.store?.zone ?? "UTC");
    if (warning === null) return nothing;
    return html`<t-banner kind=${warning.kind}>${warning.text} <a href="/admin/storage">${msg("See what takes the room")}</a></t-banner>`;
  }

  private isAdmin(): boolean {
    return this.session.store?.person?.admin === true;
  }

  private async loadForecast(): Promise<void> {
    if (!this.isAdmin()) return;
    try {
      this.outlook = await new AdminApi(this.api).storageForecast();
    } catch {
      // Nothing is said of what is not known; that the hub cannot be reached is told elsewhere.
      this.outlook = null;
    }
  }
}

declare global {
  interface HTMLElementTagNameMap {
    "t-storage-warning": StorageWarning;
  }
}
