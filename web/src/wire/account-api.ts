/** What a person may ask of the hub about their own account. */

import type { FactorOffer, NewToken, OidcConnection, PasskeyAdded, PasskeyList, PasskeyOptions, PermissionShape, SessionList, SessionShape, TokenList, TokenShape, UnitChoice, UnitChoiceList } from "../generated/api.js";
import type { HubApi } from "./hub-api.js";
import { createPasskey, usePasskey } from "./passkeys.js";

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

  /** The units of the values that one may see, with what they can be shown in. */
  async units(): Promise<readonly UnitChoice[]> {
    return (await this.hub.request<UnitChoiceList>("GET", "/api/me/units")).units;
  }

  /** @param shown by stored unit; what is not named is as the site has it */
  async chooseUnits(shown: Readonly<Record<string, string>>): Promise<void> {
    await this.hub.request("PUT", "/api/me/units", { shown });
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

  /** The person has read that somebody tried codes. */
  async seeAlert(): Promise<void> {
    await this.hub.request("POST", "/api/me/factor/seen", {});
  }

  passkeys(): Promise<PasskeyList> {
    return this.hub.request("GET", "/api/me/passkeys");
  }

  /** Lets the browser make one; gives recovery codes where it is the first second factor. */
  async addPasskey(name: string): Promise<readonly string[]> {
    const { options } = await this.hub.request<PasskeyOptions>("POST", "/api/me/passkeys/options", {});
    const credential = await createPasskey(options);
    return (await this.hub.request<PasskeyAdded>("POST", "/api/me/passkeys", { name, credential })).recovery;
  }

  async renamePasskey(passkey: string, name: string): Promise<void> {
    await this.hub.request("PATCH", `/api/me/passkeys/${encodeURIComponent(passkey)}`, { name });
  }

  /** Whether the provider signs this person in. */
  async isConnected(): Promise<boolean> {
    return (await this.hub.request<OidcConnection>("GET", "/api/me/oidc")).connected;
  }

  /** The provider signs this person in no more, and their other sessions end. */
  async disconnect(): Promise<void> {
    await this.hub.request("DELETE", "/api/me/oidc");
  }

  async removePasskey(passkey: string): Promise<void> {
    await this.hub.request("DELETE", `/api/me/passkeys/${encodeURIComponent(passkey)}`);
  }

  /** Proves by a passkey that it is the person; the password is needed where its device did not ask who holds it. */
  async confirmByPasskey(password: string): Promise<void> {
    const { options } = await this.hub.request<PasskeyOptions>("POST", "/api/me/passkeys/challenge", {});
    const credential = await usePasskey(options);
    await this.hub.request("POST", "/api/me/confirm", password === "" ? { credential } : { password, credential });
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
