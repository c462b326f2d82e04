/** What may be asked of the rules by which notices become rapid requests of a proposal. */

import type { AlertPreview, AlertRuleAsk, AlertRuleList } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

export class AlertRulesApi {
  constructor(
    private readonly hub: Pick<HubApi, "request">,
    private readonly site: string,
    private readonly proposal: string,
  ) {}

  listRules(): Promise<AlertRuleList> {
    return this.hub.request("GET", this.url("alert-rules"));
  }

  async addRule(asked: AlertRuleAsk): Promise<void> {
    await this.hub.request("POST", this.url("alert-rules"), asked);
  }

  async changeRule(rule: string, asked: AlertRuleAsk): Promise<void> {
    await this.hub.request("PUT", this.url(`alert-rules/${encodeURIComponent(rule)}`), asked);
  }

  async removeRule(rule: string): Promise<void> {
    await this.hub.request("DELETE", this.url(`alert-rules/${encodeURIComponent(rule)}`));
  }

  /** What a rule would have made of the last notices; keeps nothing. */
  previewRule(asked: AlertRuleAsk): Promise<AlertPreview> {
    return this.hub.request("POST", this.url("alert-preview"), asked);
  }

  private url(more: string): string {
    return `/api/sites/${encodeURIComponent(this.site)}/proposals/${encodeURIComponent(this.proposal)}/${more}`;
  }
}
