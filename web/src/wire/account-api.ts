/** What a person may ask of the hub about their own account. */

import type { FactorOffer, NewToken, PermissionShape, SessionList, SessionShape, TokenList, TokenShape } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";

export class AccountApi {
  constructor(private readonly hub: Pick<HubApi, "request">) {}

  /** Proves anew that it is the person; for minutes they may give rights away. */
  async confirm(password: string, code: string): Promise<void> {
    await this.hub.request("POST", "/api/me/confirm", code === "" ? { password } : { password, code });
  }

  /** Every other session ends with it. */
  async changePassword(old: string, fresh: string): Promise<void> {
    await this.hub.request("POST", "/api/me/password", { old, new: fresh });
  }

  async sessions(): Promise<readonly SessionShape[]> {
    return (await this.hub.request<SessionList>("GET", "/api/me/sessions")).sessions;
  }

  async endSession(session: string): Promise<void> {
    await this.hub.request("DELETE", `/api/me/sessions/${encodeURIComponent(session)}`);
  }

  /** Ends all but this one. */
  async endOtherSessions(): Promise<void> {
    await this.hub.request("DELETE", "/api/me/sessions");
  }

  /** It is not asked for at sign-in until `confirmFactor`. */
  offerFactor(password: string): Promise<FactorOffer> {
    return this.hub.request("POST", "/api/me/factor", { password });
  }

  /** Gives the recovery codes; they are not shown again. */
  async confirmFactor(code: string): Promise<readonly string[]> {
    return (await this.hub.request<{ recovery: readonly string[] }>("POST", "/api/me/factor/confirm", { code })).recovery;
  }

  async removeFactor(password: string, code: string): Promise<void> {
    await this.hub.request("POST", "/api/me/factor/remove", { password, code });
  }

  async tokens(): Promise<readonly TokenShape[]> {
    return (await this.hub.request<TokenList>("GET", "/api/me/tokens")).tokens;
  }

  /** The token is not shown again. */
  makeToken(name: string, endsUs: number, permissions: readonly PermissionShape[]): Promise<NewToken> {
    return this.hub.request("POST", "/api/me/tokens", { name, ends_us: endsUs, permissions });
  }

  async revokeToken(token: string): Promise<void> {
    await this.hub.request("DELETE", `/api/me/tokens/${encodeURIComponent(token)}`);
  }
}
