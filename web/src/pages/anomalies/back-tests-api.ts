/** Back-tests at the hub: what a detector would have said of stored history. */

import type { BackTestAsk, BackTestShape } from "../../generated/api.js";
import type { HubApi } from "../../wire/hub-api.js";

export class BackTestsApi {
  constructor(
    private readonly api: HubApi,
    private readonly site: string,
  ) {}

  beginTest(ask: BackTestAsk): Promise<BackTestShape> {
    return this.api.request("POST", this.path(), ask);
  }

  showTest(key: string): Promise<BackTestShape> {
    return this.api.request("GET", `${this.path()}/${encodeURIComponent(key)}`);
  }

  cancelTest(key: string): Promise<void> {
    return this.api.request("DELETE", `${this.path()}/${encodeURIComponent(key)}`);
  }

  private path(): string {
    return `/api/sites/${encodeURIComponent(this.site)}/anomalies/tests`;
  }
}
